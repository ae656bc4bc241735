//! The base folder: where deployments live on this machine.
//!
//! The process that starts a deployment and the processes that join must look in the same place. Therefore [`find`]
//! is the only rule, and no other code chooses a folder:
//!
//! | | base folder | taken if |
//! |---|---|---|
//! | 1 | `$KOSEKI_ROOT` (`koseki --root DIR` sets the variable, for child processes too) | if set |
//! | 2 | `/run/koseki` | it is there and belongs to this user |
//! | 3 | `$XDG_RUNTIME_DIR/koseki` | that folder belongs to this user |
//! | 4 | `/tmp/koseki-<user number>` | it is free, or belongs to this user |
//! | 5 | `/tmp/koseki-<user number>-<8 random digits>` | another user sits on the fourth |
//!
//! The last two are in folders in which every user can create files, so that names prove nothing. The owner cannot be
//! forged: a valid folder belongs to this user, is no link, is writable by no other user, and is below folders in which
//! no other user can replace it (`check`). Nothing in any other folder is read or written.

use std::fs::{self, DirBuilder, Metadata};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};

use rustix::process::geteuid;

use crate::error::{BusError, io_error};
use crate::seal;

const OF_SYSTEM: &str = "/run/koseki";
const OF_ALL: &str = "/tmp";

/// The base folder of this process; see the module's table. The folder need not exist.
pub fn find() -> PathBuf {
    let set = |name: &str| {
        std::env::var_os(name)
            .filter(|value| !value.is_empty())
            .map(PathBuf::from)
    };
    if let Some(folder) = set("KOSEKI_ROOT") {
        return folder;
    }
    if is_own_folder(Path::new(OF_SYSTEM)) {
        return OF_SYSTEM.into();
    }
    if let Some(folder) = set("XDG_RUNTIME_DIR").filter(|folder| is_own_folder(folder)) {
        return folder.join("koseki");
    }
    in_common_folder(Path::new(OF_ALL))
}

/// This user's folder in `folder`, where every user can make some.
fn in_common_folder(folder: &Path) -> PathBuf {
    let name = format!("koseki-{}", geteuid().as_raw());
    let plain = folder.join(&name);
    if is_own_folder(&plain) || matches!(fs::symlink_metadata(&plain), Err(error) if is_absent(&error)) {
        return plain;
    }
    let begin = format!("{name}-");
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let named = entries.filter(|entry| entry.file_name().as_encoded_bytes().starts_with(begin.as_bytes()));
    let own = named.map(|entry| entry.path()).filter(|path| is_own_folder(path)).min();
    own.unwrap_or_else(|| folder.join(format!("{begin}{:08x}", seal::random())))
}

/// Creates the folder if missing, and checks the folder.
pub(crate) fn make(base: &Path) -> Result<(), BusError> {
    if !check(base)? {
        DirBuilder::new()
            .recursive(true)
            .mode(0o700)
            .create(base)
            .map_err(io_error("create", base))?;
        check(base)?;
    }
    Ok(())
}

/// Whether the folder is there.
///
/// # Errors
/// [`BusError::BaseNotPrivate`] if another user could create files in the folder or replace the folder.
pub(crate) fn check(base: &Path) -> Result<bool, BusError> {
    let refused = |path: &Path, fault: &'static str| {
        Err(BusError::BaseNotPrivate {
            path: path.to_owned(),
            fault,
        })
    };
    let found = match fs::symlink_metadata(base) {
        Ok(found) => found,
        Err(error) if is_absent(&error) => return Ok(false),
        Err(error) => return Err(io_error("read", base)(error)),
    };
    if found.is_symlink() {
        return refused(base, "is a link");
    }
    if !found.is_dir() {
        return refused(base, "is no folder");
    }
    if !is_own(&found) {
        return refused(base, "belongs to another user");
    }
    if found.mode() & 0o022 != 0 {
        return refused(base, "may be written by others");
    }
    let above = base.parent().unwrap_or(base);
    let above = fs::canonicalize(above).map_err(io_error("find", above))?;
    // In a container, the machine's files may seem to have no owner.
    let system = fs::metadata("/").map_err(io_error("read", Path::new("/")))?.uid();
    for folder in above.ancestors() {
        let found = fs::symlink_metadata(folder).map_err(io_error("read", folder))?;
        if !is_own(&found) && found.uid() != system && found.uid() != 0 {
            return refused(folder, "belongs to another user");
        }
        // In a sticky folder, only the owners of files can rename files.
        if found.mode() & 0o002 != 0 && found.mode() & 0o1000 == 0 {
            return refused(folder, "may be written by others");
        }
    }
    Ok(true)
}

/// Whether a file belongs to the user that this process acts for.
pub(crate) fn is_own(found: &Metadata) -> bool {
    found.uid() == geteuid().as_raw()
}

fn is_own_folder(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_dir() && is_own(&found))
}

fn is_absent(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::NotFound
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn folder_of_all() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        set_mode(folder.path(), 0o1777);
        folder
    }

    fn set_mode(path: &Path, mode: u32) {
        use std::os::unix::fs::PermissionsExt as _;
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }

    fn fault(base: &Path) -> (PathBuf, &'static str) {
        match check(base) {
            Err(BusError::BaseNotPrivate { path, fault }) => (path, fault),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_squatted_name_is_left_to_its_squatter_and_the_next_start_finds_the_own_one_again() {
        let folder = folder_of_all();
        let plain = folder.path().join(format!("koseki-{}", geteuid().as_raw()));
        assert_eq!(in_common_folder(folder.path()), plain);
        // A planted path may be a file, a link, or the folder of another user.
        fs::create_dir(folder.path().join("mine")).unwrap();
        symlink(folder.path().join("mine"), &plain).unwrap();
        let other = in_common_folder(folder.path());
        assert_ne!(other, plain);
        assert_ne!(
            in_common_folder(folder.path()),
            other,
            "as nobody can guess it, nobody can plant it"
        );
        make(&other).unwrap();
        assert_eq!(in_common_folder(folder.path()), other);
        fs::remove_file(&plain).unwrap();
        make(&plain).unwrap();
        assert_eq!(in_common_folder(folder.path()), plain);
    }

    #[test]
    fn links_and_files_are_no_base_folders() {
        let folder = folder_of_all();
        let (target, base) = (folder.path().join("target"), folder.path().join("base"));
        make(&target).unwrap();
        symlink(&target, &base).unwrap();
        assert_eq!(fault(&base), (base.clone(), "is a link"));
        assert!(make(&base).is_err());
        fs::remove_file(&base).unwrap();
        symlink(folder.path().join("nowhere"), &base).unwrap();
        assert!(make(&base).is_err());
        assert!(!folder.path().join("nowhere").exists(), "made through a link");
        fs::remove_file(&base).unwrap();
        fs::write(&base, "").unwrap();
        assert_eq!(fault(&base), (base, "is no folder"));
    }

    #[test]
    fn others_may_write_neither_the_folder_nor_exchange_it() {
        let folder = folder_of_all();
        let (above, base) = (folder.path().join("above"), folder.path().join("above/base"));
        assert!(!check(&base).unwrap());
        make(&base).unwrap();
        assert!(check(&base).unwrap());
        set_mode(&base, 0o770);
        assert_eq!(fault(&base), (base.clone(), "may be written by others"));
        set_mode(&base, 0o700);
        set_mode(&above, 0o777);
        assert_eq!(
            fault(&base),
            (fs::canonicalize(&above).unwrap(), "may be written by others")
        );
        set_mode(&above, 0o1777);
        assert!(check(&base).unwrap(), "sticky, as /tmp is");
    }
}
