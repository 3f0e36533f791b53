//! The SIMD levels that the kernel is compiled for, chosen at run time.
//!
//! The kernel is plain Rust, compiled once for each level. Its arithmetic is + - * / and square roots, each
//! rounded as IEEE 754 says and never fused, so all levels give the same bits.

use crate::names::UnknownName;
use std::str::FromStr;

/// A set of vector instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The instructions that every machine of the architecture has: SSE2 on x86-64.
    Baseline,
    /// 8 lanes.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 16 lanes.
    #[cfg(target_arch = "x86_64")]
    Avx512,
    /// 4 lanes, which every arm64 machine has.
    #[cfg(target_arch = "aarch64")]
    Neon,
}

impl FromStr for Level {
    type Err = UnknownName;

    /// Return the level of a name if this machine has it.
    fn from_str(name: &str) -> Result<Level, UnknownName> {
        Level::available().into_iter().find(|level| level.name() == name).ok_or(UnknownName)
    }
}

impl Level {
    /// The levels of this machine, the best one last.
    pub fn available() -> Vec<Level> {
        let mut levels = vec![Level::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                levels.push(Level::Avx2);
            }
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
            {
                levels.push(Level::Avx512);
            }
        }
        #[cfg(target_arch = "aarch64")]
        levels.push(Level::Neon);
        levels
    }

    /// The best level of this machine.
    pub fn best() -> Level {
        Level::available().pop().unwrap_or(Level::Baseline)
    }

    /// `baseline`, `avx2`, `avx512` or `neon`.
    pub fn name(self) -> &'static str {
        match self {
            Level::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            Level::Neon => "neon",
        }
    }

    /// Run a kernel with the instructions of this level.
    #[inline(always)]
    pub(crate) fn run(self, work: impl Kernel) {
        match self {
            Level::Baseline => work.run(),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => x86::avx2(work),
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => x86::avx512(work),
            #[cfg(target_arch = "aarch64")]
            Level::Neon => work.run(),
        }
    }
}

/// Work that is compiled for each level: all functions it calls must be inlined.
pub(crate) trait Kernel {
    /// Run it. Mark it `#[inline(always)]`.
    fn run(self);
}

/// The only unsafe code: calls to functions compiled for instructions that only some machines have.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use crate::simd::Kernel;

    pub(super) fn avx2(work: impl Kernel) {
        #[target_feature(enable = "avx2")]
        fn compiled(work: impl Kernel) {
            work.run();
        }
        assert!(is_x86_feature_detected!("avx2"));
        // SAFETY: the machine has AVX2.
        unsafe { compiled(work) }
    }

    pub(super) fn avx512(work: impl Kernel) {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
        fn compiled(work: impl Kernel) {
            work.run();
        }
        assert!(is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512bw"));
        assert!(is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl"));
        // SAFETY: the machine has these parts of AVX-512.
        unsafe { compiled(work) }
    }
}
