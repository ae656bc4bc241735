//! A slice on loan: places in shared memory written by the publisher, and invisible to subscribers before the send.

use std::fmt;
use std::mem::MaybeUninit;
use std::ptr::NonNull;

use messages::BatchHeader;

use crate::ports::{DropGuard, Transport};
use crate::service::{Loan, PublisherPort};
use crate::transport::Payload;

/// A slice with so many places for samples, the first of which have been written; or none. Dropped, a slice is given
/// back.
pub(crate) struct LoanedSlice<S: Transport, T: Payload> {
    loan: Option<DropGuard<Loan<S>>>,
    /// First place: asking the loan for this place costs some tens of instructions.
    first: NonNull<MaybeUninit<T>>,
    places: usize,
    written: usize,
}

impl<S: Transport, T: Payload> fmt::Debug for LoanedSlice<S, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("LoanedSlice");
        shown.field("places", &self.places).field("written", &self.written);
        shown.finish_non_exhaustive()
    }
}

impl<S: Transport, T: Payload> LoanedSlice<S, T> {
    /// No slice: without places.
    #[inline]
    pub(crate) fn none() -> Self {
        Self {
            loan: None,
            first: NonNull::dangling(),
            places: 0,
            written: 0,
        }
    }

    /// Loans a slice of so many `places`; a slice that was here is given back.
    ///
    /// # Errors
    /// Why there is none.
    #[inline]
    pub(crate) fn loan(&mut self, port: &PublisherPort<S>, places: usize) -> Result<(), &'static str> {
        (self.loan, self.places, self.written) = (None, 0, 0);
        S::loan(port, places, &mut self.loan)?;
        if let Some(loan) = &mut self.loan {
            let octets = loan.payload_mut();
            debug_assert_eq!(octets.len(), places * size_of::<T>());
            (self.first, self.places) = (NonNull::from_mut(octets).cast(), places);
        }
        Ok(())
    }

    /// Number of places.
    #[inline]
    pub(crate) fn places(&self) -> usize {
        self.places
    }

    /// Number of samples written.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.written
    }

    /// Whether there is a slice, and all places of the slice have been written.
    #[inline]
    pub(crate) fn is_full(&self) -> bool {
        self.written == self.places && self.loan.is_some()
    }

    /// Begins to write the slice anew.
    pub(crate) fn empty(&mut self) {
        self.written = 0;
    }

    /// Writes `sample` to the next place; `false` if there is none.
    #[inline]
    pub(crate) fn push(&mut self, sample: &T) -> bool {
        // SAFETY: the loan has so many places of the size and alignment of `T`, with which the topic was opened, keeps
        // them for the life of the loan, and nothing but `self` refers to these places.
        let all = unsafe { NonNull::slice_from_raw_parts(self.first, self.places).as_mut() };
        let Some(place) = all.get_mut(self.written) else {
            return false;
        };
        place.write(*sample);
        self.written += 1;
        true
    }

    /// The samples written so far.
    #[inline]
    pub(crate) fn written(&mut self) -> &mut [T] {
        // SAFETY: as in `push`; so many samples have been written.
        unsafe { NonNull::slice_from_raw_parts(self.first.cast(), self.written).as_mut() }
    }

    /// Writes the header, and puts the slice into the queues of all subscribers.
    ///
    /// # Errors
    /// The reason why the slice could not be sent, for instance because places are not written.
    #[inline]
    pub(crate) fn send(&mut self, header: &BatchHeader) -> Result<(), &'static str> {
        let Some(loan) = self.loan.as_mut().filter(|_| self.written == self.places) else {
            return Err("not all samples are written");
        };
        (self.places, self.written) = (0, 0);
        let place = std::ptr::from_mut(loan.user_header_mut()).cast::<BatchHeader>();
        // SAFETY: the topic was opened with the size and alignment of a `BatchHeader` for this place; with the header,
        // and with all samples, the slice is complete.
        unsafe {
            place.write(*header);
            S::send(&mut self.loan)
        }
    }
}
