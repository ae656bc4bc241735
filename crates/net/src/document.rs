//! A document that is fetched again and again over HTTP.
//!
//! Receivers of transponders serve the state of all aircraft as a document. A thread fetches the document, since a
//! fetch may wait for the server; the owner takes what has come and never waits longer than the owner wishes. At most
//! one document waits: a slow owner gets fewer documents, never older ones.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::NetError;

/// Longest document, bytes: some ten thousand aircraft.
const DOCUMENT_OCTETS_MAX: u64 = 16 << 20;
/// Longest fetch.
const FETCH_MAX: Duration = Duration::from_secs(5);

/// What a fetch has brought: the document, or why there is none.
type Fetched = Result<Vec<u8>, String>;

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DocumentCounters {
    /// Documents handed on.
    pub documents: u64,
    /// Fetches that failed.
    pub failed: u64,
}

/// A document on a server.
#[derive(Debug)]
pub struct Document {
    fetched: Receiver<Fetched>,
    /// Ends the thread when dropped.
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
    counters: DocumentCounters,
    /// Why the latest fetch failed; empty if the fetch brought a document.
    trouble: String,
}

impl Document {
    /// Fetches the document at `url` once in each `period`.
    ///
    /// # Errors
    /// [`NetError::Setting`] if the address is no address. Whether the server is there makes no difference.
    pub fn open(url: &str, period: Duration) -> Result<Self, NetError> {
        if let Err(error) = url.parse::<ureq::http::Uri>() {
            return Err(NetError::setting("url", url, format!("is no address: {error}")));
        }
        let (to_owner, fetched) = sync_channel(1);
        let (stop, stopped) = channel();
        let url = url.to_owned();
        let thread = std::thread::Builder::new()
            .name("document".to_owned())
            .spawn(move || fetch_again(&url, period, &to_owner, &stopped))
            .map_err(|source| NetError::setting("thread", "document", source.to_string()))?;
        Ok(Self {
            fetched,
            stop: Some(stop),
            thread: Some(thread),
            counters: DocumentCounters::default(),
            trouble: String::new(),
        })
    }

    /// Waits up to `timeout` for the next document, and passes it to `visit`. A fetch that failed is counted.
    pub fn poll(&mut self, timeout: Duration, visit: impl FnOnce(&[u8])) {
        match self.fetched.recv_timeout(timeout) {
            Ok(Ok(document)) => {
                self.counters.documents += 1;
                self.trouble.clear();
                visit(&document);
            }
            Ok(Err(trouble)) => {
                self.counters.failed += 1;
                self.trouble = trouble;
            }
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
        }
    }

    /// Returns the counts since the start.
    pub fn counters(&self) -> DocumentCounters {
        self.counters
    }

    /// Returns why the latest fetch failed; empty if the fetch brought a document.
    pub fn trouble(&self) -> &str {
        &self.trouble
    }
}

impl Drop for Document {
    fn drop(&mut self) {
        self.stop = None;
        // A document that waits would keep the thread.
        while self.fetched.try_recv().is_ok() {}
        // The thread is left to a fetch that hangs: the end of the process must not wait for a server.
        if let Some(thread) = self.thread.take().filter(JoinHandle::is_finished) {
            let _ = thread.join();
        }
    }
}

fn fetch_again(url: &str, period: Duration, to_owner: &SyncSender<Fetched>, stopped: &Receiver<()>) {
    let config = ureq::Agent::config_builder().timeout_global(Some(FETCH_MAX)).build();
    let agent = ureq::Agent::new_with_config(config);
    loop {
        let fetched = agent.get(url).call().and_then(|mut response| {
            let body = response.body_mut().with_config().limit(DOCUMENT_OCTETS_MAX);
            body.read_to_vec()
        });
        if to_owner.send(fetched.map_err(|error| error.to_string())).is_err() {
            return;
        }
        if stopped.recv_timeout(period) != Err(RecvTimeoutError::Timeout) {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::net::TcpListener;

    use super::*;

    /// Polls until `is_done`, at most a minute.
    fn until(document: &mut Document, mut is_done: impl FnMut(Option<&[u8]>, &Document) -> bool) {
        for _ in 0..600 {
            let mut got = None;
            document.poll(Duration::from_millis(100), |octets| got = Some(octets.to_vec()));
            if is_done(got.as_deref(), document) {
                return;
            }
        }
        panic!("{document:?}");
    }

    #[test]
    fn documents_come_and_failures_are_counted_with_their_reason() {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/data/aircraft.json", server.local_addr().unwrap());
        let answering = std::thread::spawn(move || {
            for answer in [
                "HTTP/1.1 200 OK\r\ncontent-length: 4\r\n\r\n{\"a\"",
                "HTTP/1.1 404 Not Found\r\n\r\n",
            ] {
                let (mut connection, _) = server.accept().unwrap();
                let mut asked = [0; 1024];
                let octets = connection.read(&mut asked).unwrap();
                assert!(String::from_utf8_lossy(&asked[..octets]).starts_with("GET /data/aircraft.json"));
                connection.write_all(answer.as_bytes()).unwrap();
            }
        });
        let mut document = Document::open(&url, Duration::from_millis(1)).unwrap();
        until(&mut document, |got, _| got == Some(b"{\"a\""));
        until(&mut document, |_, document| document.trouble().contains("404"));
        answering.join().unwrap();
        until(&mut document, |_, document| document.counters().failed > 1);
        assert_eq!(document.counters().documents, 1);
    }

    #[test]
    fn what_is_no_address_is_refused() {
        assert!(Document::open("http://a b", Duration::from_secs(1)).is_err());
    }
}
