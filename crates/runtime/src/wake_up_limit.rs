//! Limit of the time that a sleeping core takes to wake up.
//!
//! An idle core goes to a state from which it comes back after 50 to 200 microseconds: more than all the work for a
//! report. The kernel avoids such states while a process holds its file for this purpose open, with the permitted time
//! written to it. The request ends with the process, however it ends.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::Path;

/// The kernel's file.
const FILE: &str = "/dev/cpu_dma_latency";

/// Request to the kernel, which holds as long as this lives.
#[derive(Debug)]
pub struct WakeUpLimit {
    _file: File,
}

impl WakeUpLimit {
    /// Requests that all cores wake up within `limit_us` microseconds.
    ///
    /// # Errors
    /// One sentence, with the permission that is missing.
    pub fn request(limit_us: i32) -> Result<Self, String> {
        Self::request_in(Path::new(FILE), limit_us)
    }

    fn request_in(path: &Path, limit_us: i32) -> Result<Self, String> {
        let opened = OpenOptions::new().write(true).open(path);
        let written = opened.and_then(|mut file| file.write_all(&limit_us.to_ne_bytes()).map(|()| file));
        written.map(|file| Self { _file: file }).map_err(|error| {
            format!(
                "a limit of {limit_us} µs for the wake-up of cores was refused ({}: {error}): let the user of Koseki \
                 write to this file, by a rule of udev or as root, or leave out machine.cpu_dma_latency_us",
                path.display()
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_written_as_the_kernel_reads_it_and_a_refusal_names_file_and_key() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("latency");
        let refusal = WakeUpLimit::request_in(&path, 20).unwrap_err();
        assert!(refusal.contains("machine.cpu_dma_latency_us"), "{refusal}");
        assert!(refusal.contains(&path.display().to_string()), "{refusal}");
        std::fs::write(&path, "").unwrap();
        let _held = WakeUpLimit::request_in(&path, 20).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), 20_i32.to_ne_bytes());
    }
}
