//! Command lines of `koseki` and of the programs that are built apart from it: one form of their messages.
//!
//! A refusal is one line: what is wrong, the nearest known option, and the help that says more. clap's own message has
//! several lines, with a synopsis.

#![forbid(unsafe_code)]

mod end;
mod root;
mod usage;
pub mod values;

pub use end::{CODE_FAILED, CODE_REFUSED, end_with, reason, refuse_usage};
pub use root::with_root;
pub use usage::{one_line, refusal, usage_line};
