//! A home for the deployments of one test: the executable started there, watched, and nothing left of it.
//!
//! Each test has its own folder for instances, so tests can run side by side. Nothing here waits for a time to pass:
//! every wait is for a condition, and its limit only ends a test that hangs.

use std::collections::BTreeSet;
use std::fs;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use bus::Root;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use super::folder::Folder;
use super::report;

/// Far longer than anything takes, so that only a real hang ends it.
pub(crate) const PATIENCE: Duration = Duration::from_secs(300);
/// Between two looks at whether a condition holds: many tests wait at once, and looking costs them processor time.
const PAUSE: Duration = Duration::from_millis(10);

/// A folder for instances and files of one test.
pub(crate) struct Home(Folder, Seen);

/// With what the names of the memory of all instances of a home begin, as far as anybody looked.
#[derive(Clone, Default)]
pub(crate) struct Seen(Arc<Mutex<BTreeSet<String>>>);

impl Seen {
    fn look(&self, base: &Path) {
        for instance in Root::list(base).unwrap() {
            if let Ok(Some(prefix)) = instance.root.prefix() {
                self.0.lock().unwrap().insert(prefix);
            }
        }
    }

    /// Names of the files that are in shared memory.
    fn memory(&self) -> Vec<String> {
        let prefixes = self.0.lock().unwrap();
        fs::read_dir("/dev/shm")
            .unwrap()
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| prefixes.iter().any(|prefix| name.starts_with(prefix)))
            .collect()
    }
}

impl Deref for Home {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Home {
    pub(crate) fn new() -> Self {
        Self(Folder::of_short_path(), Seen::default())
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = self.0.command("");
        command
            .args(arguments)
            .env("KOSEKI_ROOT", self.base())
            .env_remove("KOSEKI_DATA")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// Runs a command to its end.
    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        let running = self.start(arguments);
        let stdout = Arc::clone(&running.stdout);
        let (status, said) = running.end();
        let stdout = stdout.lock().unwrap().clone();
        Output {
            status,
            stdout: stdout.into_bytes(),
            stderr: said.into_bytes(),
        }
    }

    pub(crate) fn start(&self, arguments: &[&str]) -> Running {
        self.start_command(&mut self.command(arguments))
    }

    pub(crate) fn start_command(&self, command: &mut Command) -> Running {
        let mut child = command.spawn().unwrap();
        let (stdout, stderr) = (Arc::default(), Arc::default());
        let readers = vec![
            read(child.stdout.take().unwrap(), Arc::clone(&stdout)),
            read(child.stderr.take().unwrap(), Arc::clone(&stderr)),
        ];
        Running {
            child,
            stdout,
            stderr,
            readers,
            base: self.base(),
            seen: self.1.clone(),
        }
    }

    /// A demonstration all of whose processes run.
    pub(crate) fn demo(&self) -> Running {
        self.demo_with(&[])
    }

    /// The same with more arguments.
    pub(crate) fn demo_with(&self, arguments: &[&str]) -> Running {
        let demo = self.start(&[&["demo"], arguments].concat());
        demo.until_said("instance demo runs");
        demo
    }

    pub(crate) fn status(&self) -> String {
        let output = self.run(&["status"]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// What the status says of the child called `name`, when it runs.
    pub(crate) fn status_row(&self, name: &str) -> Row {
        let start = Instant::now();
        loop {
            let status = self.status();
            let rows = status.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
            let mut rows = rows.filter(|words| words.first() == Some(&name) && words.len() >= 6);
            if let Some(row) = rows.next()
                && let Ok(pid) = row[1].parse()
            {
                return Row {
                    pid,
                    state: row[2].to_owned(),
                    restarts: row[3].to_owned(),
                    published: row[5].to_owned(),
                };
            }
            assert!(start.elapsed() < PATIENCE, "no {name}: {status}");
            thread::sleep(PAUSE);
        }
    }

    /// Live processes that were started in this home.
    pub(crate) fn processes(&self) -> Vec<String> {
        let command = |pid: u32| fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        let shown = |pid| String::from_utf8_lossy(&command(pid)).replace('\0', " ");
        self.pids().into_iter().map(shown).collect()
    }

    /// Their numbers.
    pub(crate) fn pids(&self) -> Vec<u32> {
        let mark = format!("KOSEKI_ROOT={}", self.base().display());
        let pids = fs::read_dir("/proc").unwrap().flatten();
        let pids = pids.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        let is_ours = |pid: &u32| {
            let environment = fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
            environment
                .split(|byte| *byte == 0)
                .any(|variable| variable == mark.as_bytes())
        };
        pids.filter(is_ours).collect()
    }

    /// The base folder of its deployments.
    pub(crate) fn base(&self) -> PathBuf {
        self.path("koseki")
    }

    pub(crate) fn root(&self, instance: &str) -> Root {
        Root::in_base(self.base(), instance).unwrap()
    }

    /// Names of the files that instances have in shared memory.
    pub(crate) fn shared_memory(&self) -> Vec<String> {
        self.1.look(&self.base());
        self.1.memory()
    }

    pub(crate) fn assert_nothing_is_left(&self, instance: &str) {
        let root = self.root(instance);
        assert_eq!(self.processes(), [""; 0]);
        assert_eq!(self.shared_memory(), [""; 0]);
        assert!(!root.path().exists(), "{} is left", root.path().display());
        let lock = root.base().join(format!("{instance}.lock"));
        assert!(!lock.exists(), "{} is left", lock.display());
        let links = fs::read_dir(root.base()).into_iter().flatten().flatten();
        let links = links
            .filter(|entry| entry.path().is_symlink())
            .map(|entry| entry.path());
        let links: Vec<PathBuf> = links.collect();
        assert!(links.is_empty(), "what outlasts processes is left: {links:?}");
    }
}

impl Home {
    /// Removes what instances whose launcher was killed keep for their successors.
    fn forget_checkpoints(&self) {
        let base = self.base();
        let entries = fs::read_dir(&base).into_iter().flatten().flatten();
        let links = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_symlink()));
        let names = links.filter_map(|entry| entry.file_name().into_string().ok());
        for name in names {
            if let Some(Ok(root)) = name.split_once('.').map(|(instance, _)| Root::in_base(&base, instance)) {
                root.remove_outlasting();
            }
        }
    }
}

impl Drop for Home {
    /// A test that failed has killed its deployment, and must not leave memory behind either.
    fn drop(&mut self) {
        if !thread::panicking() {
            self.forget_checkpoints();
            assert_eq!(self.shared_memory(), [""; 0], "memory of deployments is left");
            return;
        }
        let start = Instant::now();
        while !self.processes().is_empty() && start.elapsed() < PATIENCE {
            thread::sleep(PAUSE);
        }
        for name in self.shared_memory() {
            let _ = fs::remove_file(Path::new("/dev/shm").join(name));
        }
        self.forget_checkpoints();
    }
}

/// A line of `koseki status`.
pub(crate) struct Row {
    pub(crate) pid: u32,
    pub(crate) state: String,
    pub(crate) restarts: String,
    pub(crate) published: String,
}

/// A `koseki` that runs. If the test fails, it is killed, and its children follow.
pub(crate) struct Running {
    pub(crate) child: Child,
    pub(crate) stdout: Arc<Mutex<String>>,
    pub(crate) stderr: Arc<Mutex<String>>,
    pub(crate) readers: Vec<JoinHandle<()>>,
    base: PathBuf,
    seen: Seen,
}

impl Running {
    pub(crate) fn pid(&self) -> u32 {
        self.child.id()
    }

    pub(crate) fn signal(&self, signal: Signal) {
        kill(self.pid(), signal);
    }

    /// Everything on standard error so far.
    pub(crate) fn said(&self) -> String {
        self.stderr.lock().unwrap().clone()
    }

    pub(crate) fn until_said(&self, words: &str) {
        let start = Instant::now();
        while !self.said().contains(words) {
            assert!(start.elapsed() < PATIENCE, "not said: {words}\n{}", self.said());
            self.seen.look(&self.base);
            thread::sleep(PAUSE);
        }
    }

    pub(crate) fn stop(self) -> (ExitStatus, String) {
        self.signal(Signal::TERM);
        self.end()
    }

    /// Waits for the end; and, because they share its standard error, for that of all its children. Each report of a
    /// deployment is checked against its counters.
    pub(crate) fn end(mut self) -> (ExitStatus, String) {
        let mut status = None;
        until("a command ends", || {
            self.seen.look(&self.base);
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        for reader in self.readers.drain(..) {
            until("its children end", || reader.is_finished());
            reader.join().unwrap();
        }
        if let Some((text, report)) = self.report() {
            let findings = report::findings(&text, &report);
            assert!(findings.is_empty(), "{findings:#?}\n{text}\n{}", self.said());
        }
        (status.unwrap(), self.said())
    }

    /// Text and file of the report of a deployment that has ended, if it wrote files.
    pub(crate) fn report(&self) -> Option<(String, Value)> {
        let printed = self.stdout.lock().unwrap();
        let begin = printed.rfind(report::BEGIN)?;
        let said = self.said();
        let (_, folder) = said.rsplit_once("this start writes to ")?;
        // Relative to the home, in which commands are started.
        let folder = self.base.parent()?.join(folder.lines().next()?);
        let file = fs::read(folder.join("report.json")).ok()?;
        Some((printed[begin..].to_owned(), serde_json::from_slice(&file).unwrap()))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub(crate) fn read(mut from: impl std::io::Read + Send + 'static, into: Arc<Mutex<String>>) -> JoinHandle<()> {
    thread::spawn(move || {
        // A character may come in two pieces.
        let (mut bytes, mut pending) = ([0; 4096], Vec::new());
        while let Ok(count @ 1..) = from.read(&mut bytes) {
            pending.extend_from_slice(&bytes[..count]);
            let whole = match std::str::from_utf8(&pending) {
                Err(error) if error.error_len().is_none() => error.valid_up_to(),
                _ => pending.len(),
            };
            let piece: Vec<u8> = pending.drain(..whole).collect();
            into.lock().unwrap().push_str(&String::from_utf8_lossy(&piece));
        }
    })
}

pub(crate) fn kill(pid: u32, signal: Signal) {
    kill_process(Pid::from_raw(pid as i32).unwrap(), signal).unwrap();
}

pub(crate) fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < PATIENCE, "never happened: {what}");
        thread::sleep(PAUSE);
    }
}
