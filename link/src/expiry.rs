//! The ends of a running link's certificates, for its health: an operator needs to know before peers refuse the link.

use std::time::SystemTime;

use deployment::{Link, LinkTls};
use runtime::Now;
use time::OffsetDateTime;

use crate::credentials::{RENEW_BEFORE, Statement, date, utc};

/// Time between two looks at the files, nanoseconds: they may be renewed meanwhile.
const LOOK_NS: i64 = 60_000_000_000;

/// Watches the certificates of a link.
pub(crate) struct ExpiryWatch {
    files: Option<LinkTls>,
    look_ns: i64,
    note: Option<String>,
}

impl ExpiryWatch {
    /// Watches those of `link`, if it has any.
    pub(crate) fn of(link: &Link) -> Self {
        Self {
            files: link.tls(),
            look_ns: i64::MIN,
            note: None,
        }
    }

    /// Looks at the files if it is time.
    pub(crate) fn look(&mut self, now: Now) {
        if now.mono_ns >= self.look_ns {
            self.look_ns = now.mono_ns + LOOK_NS;
            self.note = self.files.as_ref().and_then(|files| expiry_note(files, utc()));
        }
    }

    /// What is said of a certificate that ends soon.
    pub(crate) fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }
}

/// The note about a certificate that ends within [`RENEW_BEFORE`]; `None` for others, and for files that cannot be
/// read.
fn expiry_note(files: &LinkTls, now: SystemTime) -> Option<String> {
    let ends = [("certificate", &files.certificate), ("authority", &files.authority)];
    let ends = ends
        .into_iter()
        .filter_map(|(what, file)| Some((what, Statement::read(file).ok()?.0.until)));
    let (what, until) = ends.min_by_key(|(_, until)| *until)?;
    let now = OffsetDateTime::from(now);
    (now + RENEW_BEFORE >= until).then(|| match now >= until {
        true => format!("{what} has expired on {}", date(until)),
        false => format!("{what} expires on {}", date(until)),
    })
}
