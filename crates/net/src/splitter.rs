//! A stream of bytes into lines.
//!
//! TCP has no lines: a read may end within a line or contain many. An incomplete line waits for the end. The wait is
//! bounded, because a server without line feeds would otherwise fill the memory: after the greatest length, everything
//! up to the next line feed is skipped and counted once.

/// Bytes that are read at a time beside an incomplete line.
const READ_OCTETS: usize = 16 << 10;

/// Collects bytes until lines are complete.
#[derive(Debug)]
pub(crate) struct Splitter {
    buffer: Box<[u8]>,
    filled: usize,
    /// `None`: there are no lines.
    line_octets_max: Option<usize>,
    /// Within a line that is too long already.
    skipping: bool,
    oversized: u64,
}

impl Splitter {
    pub(crate) fn new(line_octets_max: Option<usize>) -> Self {
        Self {
            buffer: vec![0; line_octets_max.unwrap_or(0) + READ_OCTETS].into_boxed_slice(),
            filled: 0,
            line_octets_max,
            skipping: false,
            oversized: 0,
        }
    }

    /// Where the next bytes are to be put; never empty.
    pub(crate) fn free(&mut self) -> &mut [u8] {
        &mut self.buffer[self.filled..]
    }

    /// Accepts the first `octets` bytes of [free](Self::free), and passes each complete line without the end to
    /// `visit`. Empty lines, which some servers send to keep a connection alive, are skipped. Returns the number of
    /// lines. Without lines, `visit` gets the bytes.
    pub(crate) fn fill(&mut self, octets: usize, visit: &mut impl FnMut(&[u8])) -> usize {
        let Some(line_octets_max) = self.line_octets_max else {
            visit(&self.buffer[..octets]);
            return 1;
        };
        let end = self.filled + octets;
        let (mut start, mut lines) = (0, 0);
        // The bytes before contain no line feed.
        let mut searched = self.filled;
        while let Some(place) = self.buffer[searched..end].iter().position(|octet| *octet == b'\n') {
            let line = &self.buffer[start..searched + place];
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            let counted_already = std::mem::take(&mut self.skipping);
            if !counted_already && line.len() > line_octets_max {
                self.oversized += 1;
            } else if !counted_already && !line.is_empty() {
                visit(line);
                lines += 1;
            }
            searched += place + 1;
            start = searched;
        }
        self.buffer.copy_within(start..end, 0);
        self.filled = end - start;
        // A further byte may be the carriage return.
        if !self.skipping && self.filled > line_octets_max + 1 {
            self.skipping = true;
            self.oversized += 1;
        }
        if self.skipping {
            self.filled = 0;
        }
        lines
    }

    /// Discards an incomplete line; returns whether there was any.
    pub(crate) fn reset(&mut self) -> bool {
        let incomplete = self.filled > 0 && !self.skipping;
        self.filled = 0;
        self.skipping = false;
        incomplete
    }

    /// Lines that were too long.
    pub(crate) fn oversized(&self) -> u64 {
        self.oversized
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The lines of `octets`, delivered in pieces that end at `cuts`.
    fn split(splitter: &mut Splitter, octets: &[u8], cuts: &[usize]) -> Vec<Vec<u8>> {
        let mut lines = Vec::new();
        let mut put = |splitter: &mut Splitter, mut piece: &[u8]| {
            while !piece.is_empty() {
                let free = splitter.free();
                let octets = piece.len().min(free.len());
                free[..octets].copy_from_slice(&piece[..octets]);
                splitter.fill(octets, &mut |line| lines.push(line.to_vec()));
                piece = &piece[octets..];
            }
        };
        let mut done = 0;
        for cut in cuts.iter().copied().chain([octets.len()]) {
            let cut = cut.clamp(done, octets.len());
            put(splitter, &octets[done..cut]);
            done = cut;
        }
        lines
    }

    #[test]
    fn lines_end_with_a_line_feed_and_lose_a_carriage_return() {
        let mut splitter = Splitter::new(Some(10));
        assert_eq!(split(&mut splitter, b"one\r\n\r\n\ntwo\nthr", &[]), [b"one", b"two"]);
        assert_eq!(split(&mut splitter, b"ee\n", &[]), [b"three"]);
        assert!(!splitter.reset());
        split(&mut splitter, b"half", &[]);
        assert!(splitter.reset());
        assert_eq!(split(&mut splitter, b"new\n", &[]), [b"new"], "not halfnew");
    }

    #[test]
    fn a_line_may_be_exactly_as_long_as_allowed_with_either_ending() {
        let mut splitter = Splitter::new(Some(4));
        for cut in 0..6 {
            assert_eq!(split(&mut splitter, b"1234\r\n", &[cut]), [b"1234"]);
            assert_eq!(split(&mut splitter, b"1234\n", &[cut]), [b"1234"]);
        }
        assert_eq!(splitter.oversized(), 0);
        for (count, cut) in (1..).zip(0..6) {
            assert_eq!(split(&mut splitter, b"12345\nok\n", &[cut]), [b"ok"]);
            assert_eq!(splitter.oversized(), count);
        }
    }

    #[test]
    fn a_line_without_end_is_counted_once_and_takes_no_room() {
        let mut splitter = Splitter::new(Some(8));
        let endless = vec![b'x'; 10 * READ_OCTETS];
        assert!(split(&mut splitter, &endless, &[3, 5000]).is_empty());
        assert_eq!((splitter.oversized(), splitter.filled), (1, 0));
        assert_eq!(split(&mut splitter, b"tail\nnext\n", &[]), [b"next"]);
        assert_eq!(splitter.oversized(), 1);
    }

    proptest! {
        #[test]
        fn where_reads_end_makes_no_difference(
            octets in prop::collection::vec(prop::sample::select(b"ab\r\n".to_vec()), 0..200),
            mut cuts in prop::collection::vec(0usize..200, 0..20),
        ) {
            cuts.sort_unstable();
            let (mut whole, mut pieces) = (Splitter::new(Some(5)), Splitter::new(Some(5)));
            prop_assert_eq!(split(&mut whole, &octets, &[]), split(&mut pieces, &octets, &cuts));
            // A line without an end may count as too long in both, or in neither.
            prop_assert_eq!(whole.oversized(), pieces.oversized());
        }
    }
}
