//! A host: a folder in which deployments run.

use std::fs::File;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// Time that anything may take, on a machine with much else to do.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);
const PAUSE: Duration = Duration::from_millis(20);

pub(crate) struct Host {
    folder: TempDir,
    koseki: PathBuf,
    /// Processes in its namespaces of network and time, if it has them.
    inside: Option<[u32; 2]>,
}

/// The executable; `None` if it has not been built.
fn koseki() -> Option<PathBuf> {
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let given = std::env::var_os("KOSEKI").map(PathBuf::from);
    let built = ["release", "debug"].map(|profile| checkout.join("target").join(profile).join("koseki"));
    given.into_iter().chain(built).find(|path| path.is_file())
}

/// Folder of the recordings that belong to Koseki.
pub(crate) fn recordings() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/data")
}

impl Host {
    /// A host with nothing on it; `None` where the executable is missing.
    pub(crate) fn new() -> Option<Self> {
        let Some(koseki) = koseki() else {
            assert!(std::env::var_os("KOSEKI_REQUIRE_DATA").is_none(), "koseki is not built");
            println!("skipped: koseki is not built, and $KOSEKI names none");
            return None;
        };
        let folder = TempDir::new().unwrap();
        let inside = None;
        Some(Self { folder, koseki, inside })
    }

    /// What is started on it enters the namespaces of the process `inside` from now on.
    pub(crate) fn enters(&mut self, inside: u32) {
        self.inside = Some([inside; 2]);
    }

    /// What is started on it has the clocks of the process `inside` from now on, as after a reboot.
    pub(crate) fn has_clocks_of(&mut self, inside: u32) {
        let [network, _] = self.inside.unwrap_or([inside; 2]);
        self.inside = Some([network, inside]);
    }

    /// A command of `program` on this host.
    pub(crate) fn command(&self, program: &Path) -> Command {
        let mut command = match self.inside {
            Some([network, time]) => {
                let mut enter = Command::new("nsenter");
                enter.arg(format!("--net=/proc/{network}/ns/net"));
                enter.arg(format!("--time=/proc/{time}/ns/time"));
                enter.arg("--").arg(program);
                enter
            }
            None => Command::new(program),
        };
        command
            .env("KOSEKI_ROOT", self.shared())
            .env("KOSEKI_LINK", env!("CARGO_BIN_EXE_koseki-link"))
            .current_dir(self.folder.path());
        command
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Folder in which its instances live.
    pub(crate) fn shared(&self) -> PathBuf {
        self.path("shared")
    }

    /// A command of Koseki on this host.
    pub(crate) fn koseki(&self) -> Command {
        self.command(&self.koseki)
    }

    /// Starts the deployment that `config` describes.
    pub(crate) fn up(&self, name: &str, config: &str, options: &[&str]) -> Deployment {
        let path = self.path(&format!("{name}.toml"));
        std::fs::write(&path, config).unwrap();
        self.up_at(name, &path, options)
    }

    /// Starts the deployment in the folder `name`, which has its configuration.
    pub(crate) fn up_from(&self, name: &str, options: &[&str]) -> Deployment {
        self.up_at(name, Path::new(&format!("{name}/{name}.toml")), options)
    }

    fn up_at(&self, name: &str, path: &Path, options: &[&str]) -> Deployment {
        let said = self.path(&format!("{name}.txt"));
        let output = File::create(&said).unwrap();
        let mut command = self.koseki();
        command
            .arg("up")
            .arg(path)
            .arg("--data")
            .arg(recordings())
            .args(options);
        command.args(["--out", &format!("records-{name}")]).stdin(Stdio::null());
        command.stdout(output.try_clone().unwrap()).stderr(output);
        Deployment {
            launcher: command.spawn().unwrap(),
            said,
        }
    }

    /// What `koseki status --json` says of an instance.
    pub(crate) fn status(&self, instance: &str) -> String {
        let output = self
            .koseki()
            .args(["status", "--json", "--instance", instance])
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    }

    /// The system tracks that the last start of a deployment has recorded.
    pub(crate) fn system_tracks(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(&format!("records-{name}")).join("latest/system_tracks.csv")).unwrap()
    }
}

pub(crate) struct Deployment {
    launcher: Child,
    said: PathBuf,
}

impl Deployment {
    fn said(&self) -> String {
        std::fs::read_to_string(&self.said).unwrap_or_default()
    }

    /// Waits until all its processes run.
    pub(crate) fn until_up(&mut self) {
        let said = self.said.clone();
        let said = || std::fs::read_to_string(&said).unwrap_or_default();
        until(
            || {
                assert!(matches!(self.launcher.try_wait(), Ok(None)), "{}", said());
                said().contains(" runs after ")
            },
            said,
        );
    }

    /// Waits until it has ended by itself. Returns its report.
    pub(crate) fn until_ended(mut self) -> String {
        until(|| matches!(self.launcher.try_wait(), Ok(Some(_))), String::new);
        let said = self.said();
        assert!(self.launcher.wait().unwrap().success(), "{said}");
        said
    }
}

impl Drop for Deployment {
    fn drop(&mut self) {
        if matches!(self.launcher.try_wait(), Ok(None)) {
            let pid = self.launcher.id().to_string();
            let _ = Command::new("kill").args(["-TERM", &pid]).status();
            let _ = self.launcher.wait();
        }
    }
}

/// Waits until `done`; `said` explains why it did not come.
pub(crate) fn until(mut done: impl FnMut() -> bool, said: impl Fn() -> String) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < PATIENCE, "{}", said());
        std::thread::sleep(PAUSE);
    }
}

/// A port that is free now.
pub(crate) fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}
