//! Serves one page of text over HTTP, to a program that collects metrics or to a browser.
//!
//! The requests are parsed by `httparse`; the rest of HTTP that one page needs is a status line and three headers. A
//! whole server crate would bring a pool of threads, keep connections open, and (the small ones) wait for ever on a
//! client that sends nothing. Here one connection is answered at a time and then closed, a request has a greatest
//! length, and each read and write a time limit, so a client can hold up other clients for some seconds, and nobody
//! else.

use std::io::{self, Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::os::fd::AsFd as _;
use std::time::Duration;

use rustix::event::PollFlags;

use crate::error::NetError;
use crate::wait::{pause, ready};

/// Longest head of a request, octets.
const HEAD_MAX: usize = 8192;
/// Most header lines of a request.
const HEADERS_MAX: usize = 64;
/// Longest wait for a client's next octets, or for it to take ours.
const CLIENT_PATIENCE: Duration = Duration::from_millis(500);
/// Most reads for one head: a client that sends octet by octet has to end somewhere.
const READS_MAX: usize = 16;
/// Most writes for one page, for the same reason.
const WRITES_MAX: usize = 256;
/// Pause after a connection could not be accepted (no descriptor is left, say), so that trying again does not spin.
const REFUSAL_PAUSE: Duration = Duration::from_millis(100);

/// See the module's documentation.
#[derive(Debug)]
pub struct PageServer {
    listener: TcpListener,
    path: &'static str,
    content_type: &'static str,
}

impl PageServer {
    /// Listens at `address` (port 0: the system chooses one) for requests of `path`, as in `/metrics`.
    ///
    /// # Errors
    /// [`NetError::Refused`] if the address is taken or not of this machine.
    pub fn open(address: SocketAddr, path: &'static str, content_type: &'static str) -> Result<Self, NetError> {
        let refused = || format!("listening at {address}");
        let listener = TcpListener::bind(address).map_err(NetError::refused(refused()))?;
        // A client may have gone between the notice of it and its being accepted.
        listener.set_nonblocking(true).map_err(NetError::refused(refused()))?;
        Ok(Self {
            listener,
            path,
            content_type,
        })
    }

    /// Where it listens.
    ///
    /// # Errors
    /// If the system does not say.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Waits up to `timeout` for a client and answers it; `page` makes the text, if that is what is asked for. Returns
    /// whether there was a client. What goes wrong with a client is the client's trouble.
    ///
    /// # Errors
    /// If the system refuses to wait.
    pub fn serve(&self, timeout: Duration, page: impl FnOnce() -> String) -> io::Result<bool> {
        if !ready(self.listener.as_fd(), PollFlags::IN, timeout)? {
            return Ok(false);
        }
        match self.listener.accept() {
            Ok((client, _)) => {
                let _ = self.answer(client, page);
                Ok(true)
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(false),
            Err(_) => {
                pause(REFUSAL_PAUSE)?;
                Ok(false)
            }
        }
    }

    fn answer(&self, mut client: TcpStream, page: impl FnOnce() -> String) -> io::Result<()> {
        client.set_nonblocking(false)?;
        client.set_read_timeout(Some(CLIENT_PATIENCE))?;
        client.set_write_timeout(Some(CLIENT_PATIENCE))?;
        let asked = self.read(&mut client)?;
        let (status, text) = match asked {
            Asked::Page | Asked::Head => ("200 OK", page()),
            Asked::Elsewhere => ("404 Not Found", format!("There is nothing here but {}.\n", self.path)),
            Asked::Otherwise => ("405 Method Not Allowed", "This can only be read (GET).\n".to_owned()),
            Asked::Unclear => ("400 Bad Request", "That is no request of HTTP.\n".to_owned()),
        };
        let content_type = match asked {
            Asked::Page | Asked::Head => self.content_type,
            _ => "text/plain; charset=utf-8",
        };
        let allow = if asked == Asked::Otherwise {
            "Allow: GET, HEAD\r\n"
        } else {
            ""
        };
        let mut answer = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {content_type}\r\nContent-Length: {}\r\n{allow}Connection: close\r\n\r\n",
            text.len()
        );
        if asked != Asked::Head {
            answer.push_str(&text);
        }
        write(&mut client, answer.as_bytes())?;
        client.shutdown(Shutdown::Write)
    }

    fn read(&self, client: &mut TcpStream) -> io::Result<Asked> {
        let mut head = [0; HEAD_MAX];
        let mut length = 0;
        for _ in 0..READS_MAX {
            let count = match client.read(&mut head[length..]) {
                Ok(0) => break,
                Ok(count) => count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            length += count;
            if let Some(asked) = self.understand(&head[..length]) {
                return Ok(asked);
            }
        }
        Ok(Asked::Unclear)
    }

    /// What a request asks for; `None` while its head is not complete.
    fn understand(&self, head: &[u8]) -> Option<Asked> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS_MAX];
        let mut request = httparse::Request::new(&mut headers);
        match request.parse(head) {
            Ok(httparse::Status::Partial) => return None,
            Ok(httparse::Status::Complete(_)) => {}
            Err(_) => return Some(Asked::Unclear),
        }
        let path = request.path.unwrap_or_default();
        let path = path.split(['?', '#']).next().unwrap_or_default();
        Some(match request.method {
            _ if path != self.path => Asked::Elsewhere,
            Some("GET") => Asked::Page,
            Some("HEAD") => Asked::Head,
            _ => Asked::Otherwise,
        })
    }
}

/// What a client wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    Page,
    /// What would come with the page, without it.
    Head,
    /// Something that is not here.
    Elsewhere,
    /// The page, but not to read it.
    Otherwise,
    Unclear,
}

fn write(client: &mut TcpStream, mut octets: &[u8]) -> io::Result<()> {
    for _ in 0..WRITES_MAX {
        match client.write(octets) {
            Ok(count) => octets = &octets[count..],
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
        if octets.is_empty() {
            return Ok(());
        }
    }
    Err(io::ErrorKind::TimedOut.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(30);

    fn server() -> PageServer {
        PageServer::open("127.0.0.1:0".parse().unwrap(), "/page", "text/plain; version=1").unwrap()
    }

    /// What `server` answers to `request`, of which the client sends each part by itself.
    fn answer(server: &PageServer, request: &[&[u8]]) -> String {
        let mut client = TcpStream::connect(server.local_address().unwrap()).unwrap();
        client.set_nodelay(true).unwrap();
        let request: Vec<Vec<u8>> = request.iter().map(|part| part.to_vec()).collect();
        let client = std::thread::spawn(move || {
            for part in request {
                client.write_all(&part).unwrap();
            }
            let mut answer = String::new();
            client.read_to_string(&mut answer).unwrap();
            answer
        });
        assert!(server.serve(LONG, || "What there is.\n".to_owned()).unwrap());
        client.join().unwrap()
    }

    #[test]
    fn the_page_is_served_whole_with_its_type_and_length() {
        let server = server();
        let parts: [&[u8]; 2] = [b"GET /page?x=1 HTTP/1.1\r\nHost: here\r\n", b"\r\n"];
        assert_eq!(
            answer(&server, &parts),
            "HTTP/1.1 200 OK\r\nContent-Type: text/plain; version=1\r\nContent-Length: 15\r\nConnection: close\r\n\r\n\
             What there is.\n"
        );
        let head = answer(&server, &[b"HEAD /page HTTP/1.0\r\n\r\n"]);
        assert!(
            head.starts_with("HTTP/1.1 200 OK\r\n") && head.contains("Content-Length: 15\r\n"),
            "{head}"
        );
        assert!(head.ends_with("\r\n\r\n"), "{head}");
    }

    #[test]
    fn everything_else_is_refused_with_the_reason() {
        let server = server();
        for (request, status) in [
            (&b"GET / HTTP/1.1\r\n\r\n"[..], "404 Not Found"),
            (b"POST /page HTTP/1.1\r\n\r\n", "405 Method Not Allowed"),
            (b"\x16\x03\x01 nonsense\r\n\r\n", "400 Bad Request"),
            (&[b'A'; HEAD_MAX], "400 Bad Request"),
        ] {
            let answer = answer(&server, &[request]);
            assert!(answer.starts_with(&format!("HTTP/1.1 {status}\r\n")), "{answer}");
        }
    }

    #[test]
    fn clients_that_say_nothing_or_leave_hold_up_nobody_for_long() {
        let server = server();
        let silent = TcpStream::connect(server.local_address().unwrap()).unwrap();
        drop(TcpStream::connect(server.local_address().unwrap()).unwrap());
        let page = || panic!("nobody asked for it");
        assert!(server.serve(LONG, page).unwrap());
        assert!(server.serve(LONG, page).unwrap());
        drop(silent);
        assert!(!server.serve(Duration::ZERO, page).unwrap());
        let served = answer(&server, &[b"GET /page HTTP/1.1\r\n\r\n"]);
        assert!(served.ends_with("What there is.\n"), "{served}");
    }

    #[test]
    fn an_address_in_use_is_named_with_a_remedy() {
        let server = server();
        let address = server.local_address().unwrap();
        let error = PageServer::open(address, "/page", "text/plain")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(&address.to_string()) && error.contains("ss -ltunp"),
            "{error}"
        );
    }
}
