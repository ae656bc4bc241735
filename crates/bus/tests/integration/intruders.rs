//! What other users, and folders that are not ours, can do to a deployment: nothing.

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::os::unix::process::CommandExt as _;
use std::process::Command;

use crate::common::{Home, Line, memory_of, send, take_all};
use bus::{Bus, BusError, Root, SharedMemory};

/// A user that owns nothing here.
const OTHER_USER: u32 = 54_321;

fn is_root() -> bool {
    rustix::process::geteuid().is_root()
}

/// Runs a line of the shell as another user; whether it succeeded.
fn as_other_user(line: &str) -> bool {
    let mut shell = Command::new("sh");
    shell
        // Another test's listener sets the mask of the whole process for a moment, and the child inherits it.
        .args(["-c", &format!("umask 022; {line}")])
        .uid(OTHER_USER)
        .gid(OTHER_USER)
        .current_dir("/");
    let output = shell.output().unwrap();
    println!("{line}: {output:?}");
    output.status.success()
}

#[test]
fn a_folder_that_is_not_ours_is_neither_removed_nor_used() {
    let home = Home::unclaimed();
    let (folder, base) = (home.root().path().to_owned(), home.root().base().to_owned());
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("thesis"), "ten years of work").unwrap();
    let lock = base.join("test.lock");
    for _ in 0..2 {
        let error = home.root().claim().unwrap_err();
        assert!(
            matches!(&error, BusError::NotOurs { path } if *path == folder),
            "{error}"
        );
        assert!(!lock.exists(), "a refused start leaves no lock file");
        let _ = Bus::<SharedMemory>::open(home.root(), "reader").unwrap_err();
    }
    assert_eq!(fs::read_to_string(folder.join("thesis")).unwrap(), "ten years of work");
    // Nor through a link, nor what happens to be called like a lock.
    fs::rename(&folder, base.join("elsewhere")).unwrap();
    symlink(base.join("elsewhere"), &folder).unwrap();
    assert!(matches!(home.root().claim(), Err(BusError::NotOurs { .. })));
    assert!(base.join("elsewhere/thesis").exists());
    fs::remove_file(&folder).unwrap();
    fs::write(&lock, "keys of the house").unwrap();
    let error = home.root().claim().unwrap_err();
    assert!(matches!(&error, BusError::NotOurs { path } if *path == lock), "{error}");
    assert_eq!(fs::read_to_string(&lock).unwrap(), "keys of the house");
    fs::remove_file(&lock).unwrap();
    fs::remove_dir_all(base.join("elsewhere")).unwrap();
    home.root().claim().unwrap().remove().unwrap();
}

#[test]
fn a_link_in_the_place_of_the_base_folder_leads_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let (private, base) = (folder.path().join("private"), folder.path().join("base"));
    fs::create_dir_all(private.join("test")).unwrap();
    fs::set_permissions(&private, fs::Permissions::from_mode(0o700)).unwrap();
    fs::write(private.join("test/thesis"), "").unwrap();
    symlink(&private, &base).unwrap();
    let root = Root::in_base(&base, "test").unwrap();
    assert!(matches!(root.claim(), Err(BusError::BaseNotPrivate { .. })));
    assert!(matches!(root.holder(), Err(BusError::BaseNotPrivate { .. })));
    assert!(matches!(
        Bus::<SharedMemory>::open(&root, "reader"),
        Err(BusError::BaseNotPrivate { .. })
    ));
    assert!(private.join("test/thesis").exists());
    assert_eq!(fs::read_dir(&private).unwrap().count(), 1);
}

#[test]
fn a_killed_start_is_no_obstacle() {
    let home = Home::unclaimed();
    // Killed before there was a seal, and before anything was in it.
    fs::create_dir(home.root().path()).unwrap();
    home.root().claim().unwrap().remove().unwrap();
    fs::create_dir(home.root().path()).unwrap();
    fs::write(home.root().path().join("koseki-instance"), "").unwrap();
    home.root().claim().unwrap().remove().unwrap();
}

#[test]
fn another_user_reads_writes_blocks_and_deletes_nothing() {
    if !is_root() {
        println!("skipped: only root can act as another user");
        return;
    }
    let mut home = Home::unclaimed();
    home.claim();
    let line: Line<SharedMemory> = Line::new(&home, "a", 16, 4);
    let (mut publisher, mut subscriber) = (line.publisher(1), line.subscriber(0));
    send(&mut publisher, 3);
    let prefix = home.root().prefix().unwrap().unwrap();
    let places = [
        format!("/dev/shm/{prefix}*"),
        format!("{}/*", home.root().path().display()),
        format!("{}/*", home.root().base().display()),
    ];
    assert!(as_other_user(&format!("ls /dev/shm/{prefix}*")), "names are no secret");
    for place in &places {
        for attack in [
            "cat $f",
            "echo x > $f",
            "rm -rf $f",
            "mv $f $f.x",
            "chmod 666 $f",
            "ln $f /dev/shm/stolen",
        ] {
            let line = format!("for f in {place}; do test -e $f || exit 1; {attack} && exit 0; done; exit 1");
            assert!(!as_other_user(&line), "{line}");
        }
    }
    assert!(!as_other_user(&format!("kill -STOP {}", std::process::id())));
    // Names that are planted in shared memory, while it runs and before, are in nobody's way.
    let planted = format!("/dev/shm/{prefix}planted");
    assert!(as_other_user(&format!("touch {planted}")));
    send(&mut publisher, 3);
    assert_eq!(take_all(&mut subscriber), [0, 1, 2, 3, 4, 5]);
    drop((publisher, subscriber, line));
    home.end();
    assert_eq!(memory_of(&prefix).len(), 1, "only what is not ours to remove");
    fs::remove_file(&planted).unwrap();
}

#[test]
fn a_folder_of_another_user_is_not_used_even_if_it_says_that_an_instance_runs() {
    if !is_root() {
        println!("skipped: only root can act as another user");
        return;
    }
    let folder = tempfile::Builder::new().prefix("k").tempdir_in("/tmp").unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o1777)).unwrap();
    let base = folder.path().join("base");
    let planted = format!(
        "mkdir -p {0}/test; echo 1 > {0}/test.lock; echo k01234567_ > {0}/test/koseki-instance",
        base.display()
    );
    assert!(as_other_user(&planted));
    let root = Root::in_base(&base, "test").unwrap();
    for error in [
        root.claim().map(drop).unwrap_err(),
        root.holder().map(drop).unwrap_err(),
        Root::list(&base).map(drop).unwrap_err(),
        Bus::<SharedMemory>::open(&root, "reader").map(drop).unwrap_err(),
    ] {
        let said = error.to_string();
        assert!(
            said.contains("belongs to another user") && said.contains("--root"),
            "{said}"
        );
    }
    assert_eq!(memory_of("k01234567_"), [""; 0]);
}
