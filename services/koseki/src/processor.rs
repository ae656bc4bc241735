//! The same program with instructions of newer processors.
//!
//! Packages contain the program twice: for every processor with 64 bits, and for the level x86-64-v3 (AVX2, of 2013 and
//! later). The second takes an eighth fewer instructions for a report, and gives the same results to the bit: the
//! compiler contracts no multiplication and addition by itself. A program that depends on a processor ends with an
//! illegal instruction on another, so the first decides, before anything else, and becomes the second.

use std::ffi::OsStr;
use std::os::unix::process::CommandExt as _;
use std::process::Command;

/// File name of this program, and of the second one beside it.
const NAME: &str = "koseki";
const FASTER: &str = "koseki-x86-64-v3";
/// Variable that keeps the first program, with any value: for comparisons of both.
const VARIABLE: &str = "KOSEKI_ANY_PROCESSOR";

/// Becomes the program for this processor, if there is one beside this program. Returns where there is none, or the
/// program cannot be executed.
pub(crate) fn become_fastest() {
    if !has_level_3() || std::env::var_os(VARIABLE).is_some() {
        return;
    }
    let Ok(itself) = std::env::current_exe() else {
        return;
    };
    let faster = itself.with_file_name(FASTER);
    if itself.file_name() != Some(OsStr::new(NAME)) || !faster.is_file() {
        return;
    }
    let mut arguments = std::env::args_os();
    let name = arguments.next().unwrap_or_else(|| NAME.into());
    // This program serves as well.
    let _ = Command::new(faster).arg0(name).args(arguments).exec();
}

/// Returns whether the processor has all instructions that the compiler uses at level 3.
#[cfg(target_arch = "x86_64")]
fn has_level_3() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("f16c")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("movbe")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_level_3() -> bool {
    false
}
