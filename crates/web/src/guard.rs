//! Checks of each request before any other processing.

use std::net::IpAddr;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::body::Body;
use axum::http::header::{self, HeaderMap, HeaderName, HeaderValue};
use axum::http::{Method, Request, Response, StatusCode, Version};

/// Name of the cookie that holds the token.
const COOKIE: &str = "koseki_token";
/// Name of the cookie that holds the token of those who may write.
const WRITER_COOKIE: &str = "koseki_operator";
/// Headers of every answer: only content of this server is loaded, framing and type guessing are forbidden.
const HEADERS: [(HeaderName, &str); 4] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CONNECTION, "close"),
];

/// Reason for refusing a request or a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestRefusal {
    /// Another host was asked for, or none.
    Host,
    /// The WebSocket was asked for by a page of another site.
    Origin,
    /// The token is missing or wrong.
    Token,
    /// Something else than reading was asked for.
    Method,
    /// The request could not be understood.
    Malformed,
    /// There were too many clients.
    Full,
    /// The client took too long.
    Slow,
}

/// Counts of refused requests by reason. Shared among threads.
#[derive(Debug, Default)]
pub struct RequestCounts([AtomicU64; 7]);

impl RequestCounts {
    /// Counts a refused request.
    pub fn add(&self, refusal: RequestRefusal) {
        self.0[refusal as usize].fetch_add(1, Ordering::Relaxed);
    }

    /// How many were refused for this reason.
    pub fn of(&self, refusal: RequestRefusal) -> u64 {
        self.0[refusal as usize].load(Ordering::Relaxed)
    }

    /// How many were refused.
    pub fn total(&self) -> u64 {
        self.0.iter().map(|count| count.load(Ordering::Relaxed)).sum()
    }
}

/// Clients that a server answers.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    /// Accepted host names, in lower case and without ports.
    pub hosts: Vec<String>,
    /// Token required of every client; `None`: none.
    pub token: Option<String>,
    /// Clients that may write; `None`: no client.
    pub writer: Option<WriteAccess>,
    /// Pages of other sites that may open a WebSocket; `None`: no page.
    pub foreign: Option<ForeignPages>,
}

/// Pages of other sites that may open a WebSocket at one path.
#[derive(Clone, Debug)]
pub struct ForeignPages {
    /// Path of the WebSocket.
    pub path: &'static str,
    /// Sites, as browsers name them in `Origin`: `https://name`.
    pub sites: Vec<String>,
}

impl ForeignPages {
    /// Whether the request is to the path, from a page of one of the sites.
    fn admit<T>(&self, request: &Request<T>) -> bool {
        let mut origins = request.headers().get_all(header::ORIGIN).iter();
        let origin = origins.next().and_then(|origin| origin.to_str().ok());
        let is_known = |origin: &str| self.sites.iter().any(|site| site.eq_ignore_ascii_case(origin));
        request.uri().path() == self.path && origins.next().is_none() && origin.is_some_and(is_known)
    }
}

/// Clients that may write to some paths.
#[derive(Clone, Debug)]
pub struct WriteAccess {
    /// Token that these clients show: in `Authorization: Bearer …`, or in a cookie after a login.
    pub token: String,
    /// Paths of `POST` requests, all below `/api/`.
    pub paths: &'static [&'static str],
    /// Path at which a `POST` request with the token in `Authorization` gets the cookie.
    pub login: &'static str,
}

impl WriteAccess {
    /// Returns the answer to a request to one of the paths that is not to be passed on: a refusal, or the cookie.
    ///
    /// A browser attaches the cookie to requests of other sites too, unless `SameSite` is obeyed; a request with the
    /// cookie therefore needs the `Origin` of this host. A page of another site cannot set `Authorization`.
    fn stop<T>(&self, request: &Request<T>) -> Result<Option<Response<Body>>, RequestRefusal> {
        let headers = request.headers();
        let bearer = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok());
        let shown = bearer.and_then(|value| value.strip_prefix("Bearer "));
        if !is_same_origin(headers) || (shown.is_none() && !headers.contains_key(header::ORIGIN)) {
            return Err(RequestRefusal::Origin);
        }
        let is_shown = shown.is_some_and(|shown| is_equal(shown, &self.token));
        if request.uri().path() == self.login {
            let cookie = format!("{WRITER_COOKIE}={}; Path=/api; HttpOnly; SameSite=Strict", self.token);
            let answer = with(plain(StatusCode::NO_CONTENT, ""), header::SET_COOKIE, &cookie);
            return is_shown.then_some(Some(answer)).ok_or(RequestRefusal::Token);
        }
        let has_cookie = shown.is_none() && has_cookie(headers, WRITER_COOKIE, &self.token);
        (is_shown || has_cookie).then_some(None).ok_or(RequestRefusal::Token)
    }
}

impl Guard {
    /// Answer to a request that came to the address `local` and is not to be passed on: a refusal, which is counted, or
    /// the way on for a client that has shown its token.
    pub(crate) fn stop<T>(
        &self,
        request: &Request<T>,
        local: IpAddr,
        counts: &RequestCounts,
    ) -> Option<Response<Body>> {
        let refuse = |refusal, status, text| {
            counts.add(refusal);
            Some(plain(status, text))
        };
        let mut hosts = request.headers().get_all(header::HOST).iter();
        match (hosts.next(), hosts.next()) {
            (Some(host), None) if self.is_called(host.as_bytes(), local) => {}
            (Some(_), None) => {
                let text = "This is not the host that was asked for.\n";
                return refuse(RequestRefusal::Host, StatusCode::MISDIRECTED_REQUEST, text);
            }
            // Clients of version 1.0 need not name it; browsers always do.
            (None, _) if request.version() == Version::HTTP_10 => {}
            _ => {
                return refuse(
                    RequestRefusal::Malformed,
                    StatusCode::BAD_REQUEST,
                    "Exactly one Host is required.\n",
                );
            }
        }
        let path = request.uri().path();
        let is_written = |writer: &&WriteAccess| writer.paths.contains(&path) || writer.login == path;
        if let Some(writer) = self.writer.as_ref().filter(is_written)
            && *request.method() == Method::POST
        {
            return match writer.stop(request) {
                Ok(answer) => answer,
                Err(RequestRefusal::Origin) => {
                    let text = "A page of another site may not write.\n";
                    refuse(RequestRefusal::Origin, StatusCode::FORBIDDEN, text)
                }
                Err(refusal) => refuse(refusal, StatusCode::FORBIDDEN, "The operator's token is needed.\n"),
            };
        }
        if !matches!(*request.method(), Method::GET | Method::HEAD) {
            let refused = refuse(
                RequestRefusal::Method,
                StatusCode::METHOD_NOT_ALLOWED,
                "This can only be read (GET).\n",
            );
            return refused.map(|answer| with(answer, header::ALLOW, "GET, HEAD"));
        }
        let is_foreign = request.headers().contains_key(header::UPGRADE) && !is_same_origin(request.headers());
        if is_foreign && !self.foreign.as_ref().is_some_and(|foreign| foreign.admit(request)) {
            let text = "A page of another site has no access.\n";
            return refuse(RequestRefusal::Origin, StatusCode::FORBIDDEN, text);
        }
        let token = self.token.as_deref()?;
        let query = request.uri().query().unwrap_or_default();
        if let Some(shown) = value_of(query, '&', "token") {
            if !is_equal(shown, token) {
                return refuse(RequestRefusal::Token, StatusCode::FORBIDDEN, "The token is wrong.\n");
            }
            let cookie = format!("{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict");
            // The address that the browser shows and remembers no longer has it.
            let answer = with(plain(StatusCode::SEE_OTHER, ""), header::LOCATION, request.uri().path());
            return Some(with(answer, header::SET_COOKIE, &cookie));
        }
        if has_cookie(request.headers(), COOKIE, token) {
            return None;
        }
        let text = "A token is needed: /?token=…, once.\n";
        refuse(RequestRefusal::Token, StatusCode::FORBIDDEN, text)
    }

    /// Returns whether `host`, with or without a port, names this server, reached at the address `local`.
    fn is_called(&self, host: &[u8], local: IpAddr) -> bool {
        let host = String::from_utf8_lossy(host).to_ascii_lowercase();
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.contains(']') => (name, port),
            _ => (host.as_str(), ""),
        };
        let address = name.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        let known = match address {
            Ok(address) => address == local || (address.is_loopback() && local.is_loopback()),
            Err(_) => (name == "localhost" && local.is_loopback()) || self.hosts.iter().any(|known| known == name),
        };
        known && port.bytes().all(|digit| digit.is_ascii_digit())
    }
}

/// Returns whether the request comes from a page of the requested host, or from no page at all.
fn is_same_origin(headers: &HeaderMap) -> bool {
    let mut origins = headers.get_all(header::ORIGIN).iter();
    let (Some(origin), None) = (origins.next(), origins.next()) else {
        return !headers.contains_key(header::ORIGIN);
    };
    let site = origin.to_str().ok().and_then(|origin| origin.split_once("://"));
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok());
    site.zip(host)
        .is_some_and(|((scheme, site), host)| matches!(scheme, "http" | "https") && site.eq_ignore_ascii_case(host))
}

/// Returns whether the cookie `name` holds the token.
fn has_cookie(headers: &HeaderMap, name: &str, token: &str) -> bool {
    let mut cookies = headers.get_all(header::COOKIE).iter();
    cookies.any(|cookies| {
        let cookies = cookies.to_str().unwrap_or_default();
        value_of(cookies, ';', name).is_some_and(|known| is_equal(known, token))
    })
}

/// Value of `key` in a list of `key=value`.
fn value_of<'a>(list: &'a str, separator: char, key: &str) -> Option<&'a str> {
    let mut pairs = list.split(separator).filter_map(|pair| pair.trim().split_once('='));
    pairs.find(|(found, _)| *found == key).map(|(_, value)| value)
}

/// Compares two texts in a time that does not reveal the length of their common beginning.
fn is_equal(shown: &str, known: &str) -> bool {
    let differences = shown.bytes().zip(known.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
    shown.len() == known.len() && differences == 0
}

/// Answer of one line.
fn plain(status: StatusCode, text: &'static str) -> Response<Body> {
    let mut answer = Response::new(Body::from(text));
    *answer.status_mut() = status;
    with(answer, header::CONTENT_TYPE, "text/plain; charset=utf-8")
}

/// An answer with one more header; a value that none can have is left out.
fn with(mut answer: Response<Body>, name: HeaderName, value: &str) -> Response<Body> {
    if let Ok(value) = HeaderValue::from_str(value) {
        answer.headers_mut().insert(name, value);
    }
    answer
}

/// An answer with the headers of all answers.
pub(crate) fn sealed(mut answer: Response<Body>) -> Response<Body> {
    for (name, value) in HEADERS {
        // The `Connection` header of an upgrade must stay.
        answer
            .headers_mut()
            .entry(name)
            .or_insert(HeaderValue::from_static(value));
    }
    answer
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOCAL: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);

    fn status(guard: &Guard, path: &str, headers: &[(&str, &str)]) -> Option<StatusCode> {
        let mut request = Request::builder().uri(path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let counts = RequestCounts::default();
        let answer = guard.stop(&request.body(()).unwrap(), LOCAL, &counts);
        let status = answer.map(|answer| answer.status());
        let refused = status.is_some_and(|status| !status.is_redirection());
        assert_eq!(counts.total(), u64::from(refused), "{path} {headers:?}");
        status
    }

    #[test]
    fn a_page_of_another_site_may_not_open_a_socket() {
        let guard = Guard::default();
        let upgrade = |origin| {
            let headers = [("host", "localhost:8900"), ("upgrade", "websocket"), ("origin", origin)];
            status(&guard, "/ws", &headers)
        };
        for own in ["http://localhost:8900", "https://LOCALHOST:8900"] {
            assert_eq!(upgrade(own), None, "{own}");
        }
        for other in [
            "http://localhost",
            "http://localhost:8901",
            "http://evil.example",
            "http://localhost:8900.evil.example",
            "null",
            "",
            "file://localhost:8900",
        ] {
            assert_eq!(upgrade(other), Some(StatusCode::FORBIDDEN), "{other}");
        }
        let twice = [
            ("host", "localhost"),
            ("upgrade", "websocket"),
            ("origin", "http://localhost"),
            ("origin", "http://evil.example"),
        ];
        assert_eq!(status(&guard, "/ws", &twice), Some(StatusCode::FORBIDDEN));
        let script = [("host", "localhost"), ("upgrade", "websocket")];
        assert_eq!(status(&guard, "/ws", &script), None, "no page");
    }

    #[test]
    fn only_operators_write_and_no_page_of_another_site() {
        let guard = Guard {
            token: Some("viewer".to_owned()),
            writer: Some(WriteAccess {
                token: "0perator".to_owned(),
                paths: &["/api/order", "/api/alarm"],
                login: "/api/operator",
            }),
            ..Guard::default()
        };
        let post = |guard: &Guard, path: &str, headers: &[(&str, &str)]| {
            let request = Request::builder().method("POST").uri(path).header("host", "localhost");
            let request = headers
                .iter()
                .fold(request, |request, (name, value)| request.header(*name, *value));
            let answer = guard.stop(&request.body(()).unwrap(), LOCAL, &RequestCounts::default());
            answer.map(|answer| (answer.status(), answer.headers().get(header::SET_COOKIE).cloned()))
        };
        let (own, other) = (("origin", "http://localhost"), ("origin", "http://evil.example"));
        let bearer = ("authorization", "Bearer 0perator");
        let cookie = ("cookie", "koseki_operator=0perator; koseki_token=viewer");
        let forbidden = Some((StatusCode::FORBIDDEN, None));
        for passed in [&[bearer][..], &[bearer, own], &[cookie, own]] {
            assert_eq!(post(&guard, "/api/order", passed), None, "{passed:?}");
        }
        for refused in [
            &[][..],
            &[own],
            &[cookie],
            &[cookie, other],
            &[bearer, other],
            &[cookie, ("origin", "null")],
            &[("authorization", "Bearer viewer")],
            &[("authorization", "Basic 0perator"), own],
            &[("cookie", "koseki_token=viewer"), own],
            &[("cookie", "koseki_token=0perator"), own],
        ] {
            for path in ["/api/order", "/api/alarm"] {
                assert_eq!(post(&guard, path, refused), forbidden, "{path} {refused:?}");
            }
        }
        let (status, set) = post(&guard, "/api/operator", &[bearer, own]).unwrap();
        let set = set.unwrap();
        assert_eq!(status, StatusCode::NO_CONTENT);
        for part in ["koseki_operator=0perator;", "Path=/api;", "HttpOnly", "SameSite=Strict"] {
            assert!(set.to_str().unwrap().contains(part), "{set:?}");
        }
        assert_eq!(post(&guard, "/api/operator", &[cookie, own]), forbidden);
        let nowhere = post(&guard, "/api/tracks.json", &[bearer, own]).unwrap().0;
        assert_eq!(nowhere, StatusCode::METHOD_NOT_ALLOWED);
        let nobody = post(&Guard::default(), "/api/order", &[bearer, own]).unwrap().0;
        assert_eq!(nobody, StatusCode::METHOD_NOT_ALLOWED, "no operators are configured");
    }

    #[test]
    fn a_token_is_shown_once_and_then_in_a_cookie() {
        let guard = Guard {
            token: Some("s3cret".to_owned()),
            ..Guard::default()
        };
        let host = ("host", "localhost");
        let ask = |path, cookie: Option<&str>| {
            let headers = [Some(host), cookie.map(|cookie| ("cookie", cookie))];
            status(&guard, path, &headers.into_iter().flatten().collect::<Vec<_>>())
        };
        let refused = Some(StatusCode::FORBIDDEN);
        assert_eq!(ask("/", None), refused);
        assert_eq!(ask("/?token=s3cre", None), refused);
        assert_eq!(ask("/?token=s3crets", None), refused);
        assert_eq!(ask("/?x=1&token=s3cret", None), Some(StatusCode::SEE_OTHER));
        assert_eq!(ask("/ws", Some("a=b; koseki_token=s3cret")), None);
        assert_eq!(ask("/ws", Some("koseki_token=")), refused);
        assert_eq!(ask("/ws", Some("xkoseki_token=s3cret")), refused);
        let request = Request::builder().uri("/?token=s3cret").header("host", "localhost");
        let answer = guard
            .stop(&request.body(()).unwrap(), LOCAL, &RequestCounts::default())
            .unwrap();
        let cookie = answer.headers()[header::SET_COOKIE].to_str().unwrap();
        assert!(
            cookie.contains("; HttpOnly") && cookie.contains("; SameSite=Strict"),
            "{cookie}"
        );
        assert_eq!(answer.headers()[header::LOCATION], "/");
    }
}
