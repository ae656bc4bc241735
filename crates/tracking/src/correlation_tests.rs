//! In-gate matrix and track-correlation matrices (HT-5, HT-6, HT-7, SP-1, SP-3), all of them written down, with the
//! worked checks.
//!
//! The in-gate matrix of a scan has a row per detection. What a detection may be are the columns: false; one of the
//! existing tracks in whose gate it lies; the start of a new track, where that is allowed. A track-correlation matrix
//! selects one column for each row, and no track twice: one consistent interpretation of the scan. A hypothesis is
//! updated by those interpretations that refer to none but its own tracks.
//!
//! Their number grows like a factorial with the crowd, so the tracker does not make them: it draws the likeliest ones
//! in order (module `ranked`). This module says what all of them are, for a few detections: what the tracker is tested
//! against.

/// One row of an in-gate matrix: what a detection may be, besides false.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Row {
    /// Existing tracks in whose gate it lies.
    pub(crate) tracks: Vec<usize>,
    /// Whether it may start a new track.
    pub(crate) new_track: bool,
}

/// Meaning given to a detection: the column selected in its row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Interpretation {
    /// A false detection.
    False,
    /// The first detection of a new track.
    New,
    /// A detection of this existing track.
    Track(usize),
}

impl Row {
    /// A detection in the gates of `tracks` that may start a new track as well.
    pub(crate) fn of(tracks: &[usize]) -> Self {
        Self {
            tracks: tracks.to_vec(),
            new_track: true,
        }
    }

    /// The columns that hold a one, in the order false, new, tracks.
    fn columns(&self) -> impl Iterator<Item = Interpretation> + '_ {
        let new = self.new_track.then_some(Interpretation::New);
        let tracks = self.tracks.iter().copied().map(Interpretation::Track);
        [Interpretation::False].into_iter().chain(new).chain(tracks)
    }
}

/// SP-1: in a cluster with confirmed tracks, only detections in the gate of one of them may start new tracks.
pub(crate) fn start_in_confirmed_gates(rows: &mut [Row], confirmed: &[usize]) {
    if confirmed.is_empty() {
        return;
    }
    for row in rows {
        row.new_track &= row.tracks.iter().any(|track| confirmed.contains(track));
    }
}

/// All track-correlation matrices with at most `new_tracks_max` new tracks (SP-3).
pub(crate) fn matrices(rows: &[Row], new_tracks_max: usize) -> Vec<Vec<Interpretation>> {
    let mut found = Vec::new();
    extend(rows, new_tracks_max, &mut Vec::new(), &mut found);
    found
}

fn extend(rows: &[Row], new_tracks_left: usize, begun: &mut Vec<Interpretation>, found: &mut Vec<Vec<Interpretation>>) {
    let Some(row) = rows.get(begun.len()) else {
        found.push(begun.clone());
        return;
    };
    for column in row.columns() {
        let is_new = usize::from(column == Interpretation::New);
        let taken = matches!(column, Interpretation::Track(_)) && begun.contains(&column);
        if taken || is_new > new_tracks_left {
            continue;
        }
        begun.push(column);
        extend(rows, new_tracks_left - is_new, begun, found);
        begun.pop();
    }
}

/// Whether a hypothesis of these tracks is updated by `matrix` (HT-7).
pub(crate) fn applies(matrix: &[Interpretation], hypothesis: &[usize]) -> bool {
    matrix.iter().all(|column| match column {
        Interpretation::Track(track) => hypothesis.contains(track),
        Interpretation::False | Interpretation::New => true,
    })
}

/// The child's tracks (HT-3, HT-7): each of the hypothesis' tracks with the row of its detection, `None` for a memory
/// track; then the rows that start new tracks.
pub(crate) fn child(matrix: &[Interpretation], hypothesis: &[usize]) -> (Vec<(usize, Option<usize>)>, Vec<usize>) {
    let row_of = |track| matrix.iter().position(|column| *column == Interpretation::Track(track));
    let continued = hypothesis.iter().map(|track| (*track, row_of(*track))).collect();
    let new = (0..matrix.len())
        .filter(|row| matrix[*row] == Interpretation::New)
        .collect();
    (continued, new)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// T1 … T6 of the first worked check are 1 … 6.
    const HYPOTHESES: [&[usize]; 5] = [&[1, 4], &[1, 6], &[2, 5], &[2], &[5]];

    fn applicable(all: &[Vec<Interpretation>], hypotheses: &[&[usize]]) -> Vec<usize> {
        let count = |hypothesis: &&[usize]| all.iter().filter(|matrix| applies(matrix, hypothesis)).count();
        hypotheses.iter().map(count).collect()
    }

    #[test]
    fn the_first_worked_check() {
        let rows = [Row::of(&[1, 3, 5]), Row::of(&[1, 3, 5]), Row::of(&[2, 4])];
        let all = matrices(&rows, usize::MAX);
        assert_eq!(all.len(), 88);
        assert_eq!(applicable(&all, &HYPOTHESES), [24, 16, 24, 12, 16]);
    }

    #[test]
    fn the_first_worked_check_with_the_sources_list_of_updated_tracks() {
        let rows = [Row::of(&[1, 3, 5]), Row::of(&[1, 3, 5]), Row::of(&[2, 4, 6])];
        let all = matrices(&rows, usize::MAX);
        assert_eq!(all.len(), 110);
        assert_eq!(applicable(&all, &HYPOTHESES), [24, 24, 24, 12, 16]);
    }

    #[test]
    fn all_false_leaves_memory_tracks() {
        let (continued, new) = child(&[Interpretation::False; 3], HYPOTHESES[0]);
        assert_eq!((continued, new), (vec![(1, None), (4, None)], vec![]));
    }

    #[test]
    fn a_child_has_updated_new_and_memory_tracks() {
        use Interpretation::{False, New, Track};
        let (continued, new) = child(&[Track(1), New, Track(4)], HYPOTHESES[0]);
        assert_eq!((continued, new), (vec![(1, Some(0)), (4, Some(2))], vec![1]));
        let (continued, new) = child(&[False, New, Track(4)], HYPOTHESES[0]);
        assert_eq!((continued, new), (vec![(1, None), (4, Some(2))], vec![1]));
    }

    #[test]
    fn the_second_worked_check() {
        const C: usize = 0;
        const P: usize = 1;
        let rows = [Row::of(&[C]), Row::of(&[C, P]), Row::of(&[P])];
        assert_eq!(matrices(&rows, usize::MAX).len(), 30);
        for (limit, expected) in [(0, 8), (1, 22), (2, 29), (3, 30)] {
            assert_eq!(matrices(&rows, limit).len(), expected, "SP-3 with {limit}");
        }
        let mut limited = rows.clone();
        start_in_confirmed_gates(&mut limited, &[C]);
        let all = matrices(&limited, usize::MAX);
        assert_eq!(all.len(), 19, "SP-1");
        assert_eq!(applicable(&all, &[&[C, P], &[C]]), [19, 8]);
        let mut without_confirmed = rows.clone();
        start_in_confirmed_gates(&mut without_confirmed, &[]);
        assert_eq!(without_confirmed, rows);
    }
}
