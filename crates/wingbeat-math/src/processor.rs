//! What the compiled code asks of the processor.

#[cfg(all(
    target_arch = "x86_64",
    // Cargo hands its flags to the compiler alone.
    not(doc),
    not(feature = "portable"),
    not(all(target_feature = "avx2", target_feature = "fma"))
))]
compile_error!(
    "wingbeat is compiled without AVX2 and FMA: it would be slower, and its numbers would differ in their last bits. \
     Set the flags in .cargo/config.toml at the root of your own workspace:\n\n\
     [target.'cfg(target_arch = \"x86_64\")']\n\
     rustflags = [\"-C\", \"target-cpu=x86-64-v3\"]\n\n\
     or switch on the feature `portable` of wingbeat, for processors without AVX2 and FMA."
);

/// A message that needs no formatting.
#[cfg(target_arch = "x86_64")]
macro_rules! message {
    ($set:literal) => {
        concat!(
            "wingbeat is compiled for processors with ",
            $set,
            ", which this one lacks; docs/extending.md says how to build for it (feature `portable`)"
        )
    };
}
/// The message for a processor that lacks an instruction set which the code is compiled for.
///
/// A program asks first of all. What it does before must be plain: code compiled for an instruction set may use it anywhere.
#[cfg(not(target_arch = "x86_64"))]
#[must_use]
pub fn lacks() -> Option<&'static str> {
    None
}

/// The message for a processor that lacks an instruction set which the code is compiled for.
///
/// A program asks first of all. What it does before must be plain: code compiled for an instruction set may use it anywhere.
#[cfg(target_arch = "x86_64")]
#[inline(never)]
#[must_use]
pub fn lacks() -> Option<&'static str> {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    // Registers by Intel's Software Developer's Manual, volume 2A, CPUID. The macro `is_x86_feature_detected!` is no help: it
    // answers by the flags of the compiler where these have the feature.
    const XSAVE: u32 = 1 << 27;
    const AVX: u32 = 1 << 28;
    const FMA: u32 = 1 << 12;
    const BMI1: u32 = 1 << 3;
    const AVX2: u32 = 1 << 5;
    const BMI2: u32 = 1 << 8;
    const AVX512F: u32 = 1 << 16;
    let basic = __cpuid(1).ecx;
    let extended = if __cpuid(0).eax < 7 { 0 } else { __cpuid_count(7, 0).ebx };
    if cfg!(target_feature = "avx") && (basic & XSAVE == 0 || basic & AVX == 0) {
        return Some(message!("AVX"));
    }
    if cfg!(target_feature = "avx2") && extended & AVX2 == 0 {
        return Some(message!("AVX2"));
    }
    if cfg!(target_feature = "fma") && basic & FMA == 0 {
        return Some(message!("FMA"));
    }
    if cfg!(target_feature = "bmi2") && (extended & BMI1 == 0 || extended & BMI2 == 0) {
        return Some(message!("BMI"));
    }
    if cfg!(target_feature = "avx512f") && extended & AVX512F == 0 {
        return Some(message!("AVX-512"));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_that_runs_the_tests_lacks_nothing() {
        assert_eq!(lacks(), None);
    }
}
