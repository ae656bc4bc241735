//! Mapped files in shared memory: words that outlive the writer.

use std::fs::OpenOptions;
use std::io;
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;
use std::ptr::NonNull;

use rustix::fs::{FallocateFlags, OFlags, fallocate};
use rustix::mm::{MapFlags, ProtFlags, mmap, mmap_anonymous, munmap};

const ACCESS: ProtFlags = ProtFlags::READ.union(ProtFlags::WRITE);
/// Populated: no page is to be fetched in the loop.
const FLAGS: MapFlags = MapFlags::SHARED.union(MapFlags::POPULATE);

/// A completely mapped file, aligned to a page; unwritten bytes are zero.
#[derive(Debug)]
pub(crate) struct Mapping {
    start: NonNull<u8>,
    bytes: usize,
}

// SAFETY: the mapping belongs to the process, not to a thread; the users access atomic words only.
unsafe impl Send for Mapping {}

impl Mapping {
    /// Creates the file with this number of `bytes`, or opens an existing file.
    ///
    /// # Errors
    /// If the file cannot be made, or is another user's.
    pub(crate) fn create(path: &Path, bytes: usize) -> io::Result<Self> {
        let file = options().create(true).mode(0o600).open(path)?;
        // Reserved now: a write into a page for which there is no memory left would end the process.
        fallocate(&file, FallocateFlags::empty(), 0, bytes as u64)?;
        drop(file);
        Self::open(path)
    }

    /// Opens the file.
    ///
    /// # Errors
    /// If there is no file, or the file is empty or another user's.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = options().open(path)?;
        let found = file.metadata()?;
        let bytes = usize::try_from(found.len()).unwrap_or(0);
        if found.uid() != rustix::process::geteuid().as_raw() || bytes == 0 {
            return Err(io::Error::other("not a file of this user's shared memory"));
        }
        // SAFETY: a new mapping, at a place that the system chooses, overlaps nothing.
        let start = unsafe { mmap(std::ptr::null_mut(), bytes, ACCESS, FLAGS, &file, 0) }?;
        Self::at(start.cast(), bytes)
    }

    /// Memory without a file, of so many `bytes`.
    ///
    /// # Errors
    /// If there is none left.
    pub(crate) fn anonymous(bytes: usize) -> io::Result<Self> {
        // SAFETY: as in `open`.
        let start = unsafe { mmap_anonymous(std::ptr::null_mut(), bytes, ACCESS, FLAGS) }?;
        Self::at(start.cast(), bytes)
    }

    /// Moves memory without a file into a new file. The words keep address and values, provided that no other thread
    /// writes the words meanwhile.
    ///
    /// # Errors
    /// If the file cannot be created, or has another length; the memory is unchanged then.
    pub(crate) fn move_to(&self, path: &Path) -> io::Result<()> {
        let file = Self::create(path, self.bytes)?;
        let found = options().open(path)?;
        // Beyond the end of a shorter file, an access would end the process.
        if file.bytes != self.bytes || found.metadata()?.len() != self.bytes as u64 {
            return Err(io::Error::other("a file of another length"));
        }
        // SAFETY: both mappings have this number of bytes, and the file's mapping is new.
        unsafe { std::ptr::copy_nonoverlapping(self.start.as_ptr(), file.start.as_ptr(), self.bytes) };
        // SAFETY: the place is this mapping's own, and the file has as many bytes, with the same values.
        unsafe {
            mmap(
                self.start.as_ptr().cast(),
                self.bytes,
                ACCESS,
                FLAGS | MapFlags::FIXED,
                &found,
                0,
            )
        }?;
        Ok(())
    }

    fn at(start: *mut u8, bytes: usize) -> io::Result<Self> {
        let start = NonNull::new(start).ok_or_else(|| io::Error::other("mapped at zero"))?;
        Ok(Self { start, bytes })
    }

    /// First byte.
    pub(crate) fn start(&self) -> NonNull<u8> {
        self.start
    }

    /// Length in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: the mapping was made with this length, and nothing borrows from the mapping any more.
        let _ = unsafe { munmap(self.start.as_ptr().cast(), self.bytes) };
    }
}

fn options() -> OpenOptions {
    let mut options = OpenOptions::new();
    options
        .read(true)
        .write(true)
        .custom_flags(OFlags::NOFOLLOW.bits().cast_signed());
    options
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_another_length_takes_no_memory_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let memory = Mapping::anonymous(100).unwrap();
        std::fs::write(&path, [7; 101]).unwrap();
        assert!(memory.move_to(&path).is_err());
        assert_eq!(std::fs::read(&path).unwrap(), [7; 101], "and its octets stay");
        std::fs::write(&path, [7; 99]).unwrap();
        memory.move_to(&path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), [0; 100]);
    }
}
