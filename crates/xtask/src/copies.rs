//! How often generic code stands in the program, by its symbols, and how much code there is: what is compiled again for every type
//! costs every build.

use std::fs;

use crate::report::Tally;
use crate::tools;

/// A function with what its symbols hold, and the most copies of it.
struct CopyLimit {
    name: &'static str,
    holds: [&'static str; 2],
    most: usize,
}

/// Limits of the program with all formats, which has 13, 4, 4 and 143 copies. The last has one for each table that is read: serde compiles a
/// reader for every type.
const LIMITS: [CopyLimit; 4] = [
    CopyLimit { name: "StripModel::evaluate_in", holds: ["5strip", "11evaluate_in17h"], most: 14 },
    CopyLimit { name: "Tableau::integrate", holds: ["11runge_kutta", "9integrate17h"], most: 5 },
    CopyLimit { name: "Stepper::run", holds: ["Stepper$LT$", "3run17h"], most: 4 },
    CopyLimit { name: "deserialize_struct", holds: ["18deserialize_struct17h", ""], most: 144 },
];

/// Most code of the program with all formats, without incremental builds: 15.93 MB.
const MOST_CODE: f64 = 15.95;

/// Counts the copies in the program that was built.
pub fn check() -> Tally {
    let Some(program) = fs::read(tools::program()).ok().and_then(ProgramSymbols::of) else {
        println!("the program is no ELF file: its copies are not counted");
        return Tally { failed: usize::from(cfg!(target_os = "linux")), ..Tally::default() };
    };
    let mut tally = Tally::default();
    for limit in &LIMITS {
        let copies =
            program.functions.iter().filter(|name| limit.holds.iter().all(|part| name.contains(part)));
        judge(&mut tally, limit.name, copies.count() as f64, limit.most as f64, "copies");
    }
    judge(&mut tally, "code", program.code as f64 * 1e-6, MOST_CODE, "MB");
    tally
}

fn judge(tally: &mut Tally, name: &str, value: f64, most: f64, unit: &str) {
    // None at all means that the symbols are not there, or have other names.
    let passes = value > 0.0 && value <= most;
    println!("{name:<20} {value:>6.4} {unit}, at most {most}{}", if passes { "" } else { "  FAILED" });
    tally.passed += usize::from(passes);
    tally.failed += usize::from(!passes);
}

/// What of a program is looked at.
struct ProgramSymbols {
    /// Names of its functions.
    functions: Vec<String>,
    /// Size of its section `.text`, bytes.
    code: u64,
}

/// A section of an ELF file: name, where it is, and the section that it refers to.
struct ElfSection {
    name: usize,
    kind: u64,
    offset: usize,
    size: usize,
    link: usize,
}

impl ProgramSymbols {
    /// Of an ELF file of 64 bits, least byte first (System V ABI, chapter 4); none of anything else.
    fn of(bytes: Vec<u8>) -> Option<Self> {
        const SYMBOLS: u64 = 2;
        const SYMBOL: usize = 24;
        const FUNCTION: u8 = 2;
        bytes.starts_with(b"\x7fELF\x02\x01").then_some(())?;
        let number = |at: usize, digits: usize| -> Option<u64> {
            let mut value = [0; 8];
            value[..digits].copy_from_slice(bytes.get(at..at + digits)?);
            Some(u64::from_le_bytes(value))
        };
        let (table, each) = (number(0x28, 8)? as usize, number(0x3a, 2)? as usize);
        let (count, names) = (number(0x3c, 2)? as usize, number(0x3e, 2)? as usize);
        let section = |k: usize| -> Option<ElfSection> {
            let at = table + k * each;
            let word = |offset: usize, digits: usize| number(at + offset, digits);
            Some(ElfSection {
                name: word(0, 4)? as usize,
                kind: word(4, 4)?,
                offset: word(0x18, 8)? as usize,
                size: word(0x20, 8)? as usize,
                link: word(0x28, 4)? as usize,
            })
        };
        let text = |table: &ElfSection, at: usize| -> Option<String> {
            let rest = bytes.get(table.offset + at..)?;
            let end = rest.iter().position(|byte| *byte == 0)?;
            Some(String::from_utf8_lossy(&rest[..end]).into_owned())
        };
        let names = section(names)?;
        let sections: Vec<ElfSection> = (0..count).filter_map(section).collect();
        let code = sections.iter().find(|s| text(&names, s.name).as_deref() == Some(".text"))?.size as u64;
        let symbols = sections.iter().find(|section| section.kind == SYMBOLS)?;
        let strings = sections.get(symbols.link)?;
        let functions = (0..symbols.size / SYMBOL).filter_map(|k| {
            let at = symbols.offset + k * SYMBOL;
            (bytes.get(at + 4)? & 0xf == FUNCTION).then(|| text(strings, number(at, 4)? as usize))?
        });
        Some(Self { functions: functions.collect(), code })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn this_very_program_is_read() {
        let program = ProgramSymbols::of(fs::read(std::env::current_exe().unwrap()).unwrap()).unwrap();
        let own = program.functions.iter().filter(|name| name.contains("main"));
        assert!(own.count() > 0 && program.code > 10_000, "{} B of code", program.code);
        assert!(ProgramSymbols::of(b"MZ".to_vec()).is_none());
    }
}
