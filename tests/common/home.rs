//! A home for the deployments of one test: the executable started there, watched, and nothing left of it.
//!
//! Each test has its own folder for instances, so tests can run side by side. Nothing here waits for a time to pass:
//! every wait is for a condition, and its limit only ends a test that hangs.

use std::fs;
use std::ops::Deref;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use bus::Root;
use rustix::process::{Pid, Signal, kill_process};

use super::folder::Folder;

/// Far longer than anything takes, so that only a real hang ends it.
pub(crate) const PATIENCE: Duration = Duration::from_secs(90);

/// A folder for instances and files of one test.
pub(crate) struct Home(Folder);

impl Deref for Home {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Home {
    pub(crate) fn new() -> Self {
        Self(Folder::of_short_path())
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = self.0.command("");
        command
            .args(arguments)
            .env("XDG_RUNTIME_DIR", self.0.folder())
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
        Self::start_command(&mut self.command(arguments))
    }

    pub(crate) fn start_command(command: &mut Command) -> Running {
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
        }
    }

    /// Live processes that were started in this home.
    pub(crate) fn processes(&self) -> Vec<String> {
        let mark = format!("XDG_RUNTIME_DIR={}", self.0.folder().display());
        let mut found = Vec::new();
        for entry in fs::read_dir("/proc").unwrap().flatten() {
            let environment = fs::read(entry.path().join("environ")).unwrap_or_default();
            if environment
                .split(|byte| *byte == 0)
                .any(|variable| variable == mark.as_bytes())
            {
                let command = fs::read(entry.path().join("cmdline")).unwrap_or_default();
                found.push(String::from_utf8_lossy(&command).replace('\0', " "));
            }
        }
        found
    }

    pub(crate) fn root(&self, instance: &str) -> Root {
        Root::in_base(self.path("koseki"), instance).unwrap()
    }

    /// Names of the files that an instance has in shared memory.
    pub(crate) fn shared_memory(&self, instance: &str) -> Vec<String> {
        let root = self.root(instance);
        fs::read_dir("/dev/shm")
            .unwrap()
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| name.starts_with(root.prefix()))
            .collect()
    }

    pub(crate) fn assert_nothing_is_left(&self, instance: &str) {
        let root = self.root(instance);
        assert_eq!(self.processes(), [""; 0]);
        assert_eq!(self.shared_memory(instance), [""; 0]);
        assert!(!root.path().exists(), "{} is left", root.path().display());
        let lock = root.base().join(format!("{instance}.lock"));
        assert!(!lock.exists(), "{} is left", lock.display());
    }
}

impl Drop for Home {
    /// A test that failed has killed its deployment, and must not leave memory behind either.
    fn drop(&mut self) {
        if !thread::panicking() {
            return;
        }
        let start = Instant::now();
        while !self.processes().is_empty() && start.elapsed() < PATIENCE {
            thread::sleep(Duration::from_millis(2));
        }
        for instance in ["demo", "test", "beside"] {
            for name in self.shared_memory(instance) {
                let _ = fs::remove_file(Path::new("/dev/shm").join(name));
            }
        }
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
            thread::sleep(Duration::from_millis(2));
        }
    }

    pub(crate) fn stop(self) -> (ExitStatus, String) {
        self.signal(Signal::TERM);
        self.end()
    }

    /// Waits for the end; and, because they share its standard error, for that of all its children.
    pub(crate) fn end(mut self) -> (ExitStatus, String) {
        let mut status = None;
        until("a command ends", || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        for reader in self.readers.drain(..) {
            until("its children end", || reader.is_finished());
            reader.join().unwrap();
        }
        (status.unwrap(), self.said())
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
        let mut bytes = [0; 4096];
        while let Ok(count @ 1..) = from.read(&mut bytes) {
            into.lock().unwrap().push_str(&String::from_utf8_lossy(&bytes[..count]));
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
        thread::sleep(Duration::from_millis(2));
    }
}
