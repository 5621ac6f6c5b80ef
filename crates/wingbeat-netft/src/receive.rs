//! Datagrams from the kernel into a queue, by a thread that does nothing else.

use std::io::IoSliceMut;
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::AsRawFd;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use nix::cmsg_space;
use nix::sys::socket::{
    ControlMessageOwned, MsgFlags, SockaddrStorage, getsockopt, recvmsg, setsockopt, sockopt,
};
use nix::sys::time::TimeSpec;

use crate::Error;

/// Longest wait for a datagram.
pub const PATIENCE: Duration = Duration::from_millis(50);
/// Largest datagram.
pub const LARGEST: usize = 64 << 10;

/// A datagram with the times of its arrival.
pub struct Datagram {
    pub bytes: Vec<u8>,
    /// Clock of the kernel, ns since 1970; 0 when not known.
    pub kernel_ns: u64,
    /// Clock of the host, ns since 1970.
    pub host_ns: u64,
}

/// A socket to `address` with a large receive buffer, time stamps and the kernel's drop counter; and the size of the
/// buffer that the kernel granted, bytes.
pub fn open(address: SocketAddr, buffer_bytes: usize) -> Result<(UdpSocket, usize), Error> {
    let any: SocketAddr = if address.is_ipv4() { ([0, 0, 0, 0], 0).into() } else { ([0u16; 8], 0).into() };
    let failed = |e| Error::network("UDP socket", e);
    let socket = UdpSocket::bind(any).map_err(failed)?;
    socket.connect(address).map_err(|e| Error::network(address.to_string(), e))?;
    socket.set_read_timeout(Some(PATIENCE)).map_err(failed)?;
    let set = |e: nix::Error| Error::network("UDP socket options", e);
    // Beyond net.core.rmem_max only the administrator may ask.
    if setsockopt(&socket, sockopt::RcvBufForce, &buffer_bytes).is_err() {
        setsockopt(&socket, sockopt::RcvBuf, &buffer_bytes).map_err(set)?;
    }
    setsockopt(&socket, sockopt::ReceiveTimestampns, &true).map_err(set)?;
    setsockopt(&socket, sockopt::RxqOvfl, &1).map_err(set)?;
    let granted = getsockopt(&socket, sockopt::RcvBuf).map_err(set)?;
    Ok((socket, granted))
}

/// Moves datagrams into `queue` until told to stop; `drops` counts what the kernel threw away. A full queue leaves
/// them to the kernel's buffer.
pub fn pump(socket: &UdpSocket, queue: &SyncSender<Datagram>, drops: &AtomicU64, stop: &AtomicBool) {
    let mut buffer = vec![0u8; LARGEST];
    while !stop.load(Ordering::Relaxed) {
        if let Some(datagram) = next(socket, &mut buffer, drops)
            && queue.send(datagram).is_err()
        {
            return;
        }
    }
}

/// The next datagram; none when the wait ran out.
fn next(socket: &UdpSocket, buffer: &mut [u8], drops: &AtomicU64) -> Option<Datagram> {
    let mut control = cmsg_space!(TimeSpec, u32);
    let mut slices = [IoSliceMut::new(buffer)];
    let message =
        recvmsg::<SockaddrStorage>(socket.as_raw_fd(), &mut slices, Some(&mut control), MsgFlags::empty());
    let message = message.ok()?;
    let host_ns = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos() as u64);
    let mut kernel_ns = 0;
    for control in message.cmsgs().into_iter().flatten() {
        match control {
            ControlMessageOwned::ScmTimestampns(t) => {
                kernel_ns = t.tv_sec() as u64 * 1_000_000_000 + t.tv_nsec() as u64;
            }
            ControlMessageOwned::RxqOvfl(n) => drops.store(u64::from(n), Ordering::Relaxed),
            _ => {}
        }
    }
    let size = message.bytes;
    Some(Datagram { bytes: buffer[..size].to_vec(), kernel_ns, host_ns })
}
