//! Datagrams of the box: parsed, written back, accounted for.
#![no_main]

use libfuzzer_sys::fuzz_target;
use wingbeat::rig::netft::{Account, RECORD_BYTES, RdtRecord, Request, Scale};
use wingbeat_fuzz as _;

fuzz_target!(|bytes: &[u8]| {
    if let Some(request) = Request::parse(bytes) {
        assert_eq!(request.bytes()[..], bytes[..8]);
    }
    let Some(records) = RdtRecord::parse(bytes) else { return };
    let scale = Scale { per_newton: 1e6, per_newton_metre: 1e6 };
    let mut account = Account::default();
    for (k, (record, chunk)) in records.zip(bytes.chunks(RECORD_BYTES)).enumerate() {
        assert_eq!(record.bytes()[..], *chunk);
        assert_eq!(scale.counts(scale.wrench(record.counts)), record.counts);
        // A minute between records at most, and clocks that go back.
        let ns = (k as u64).wrapping_mul(u64::from(record.status)) * 16;
        account.take(&record, ns);
        assert!(account.booked() >= account.received);
    }
    let taken = account.received + account.duplicates;
    assert_eq!(taken as usize, bytes.len() / RECORD_BYTES);
});
