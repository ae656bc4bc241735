//! `koseki-client` for C: implements the functions declared and documented in `include/koseki.h`.
//!
//! A handle is a box; its close function takes the box back. Failures are codes; `koseki_error` returns the text
//! of the calling thread's latest failure. A panic would be a fault of this library, and ends the program.

mod observation;

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::os::fd::AsRawFd as _;
use std::ptr;
use std::time::Duration;

use koseki_client::by_name::{self, AnyPublisher, AnySlice, AnySubscription};
use koseki_client::messages::layout::Layout;
use koseki_client::messages::{BatchHeader, OrderState};
use koseki_client::{Error, ErrorKind, Orders, Root};

const OK: c_int = 0;
/// Code of a wait that ended without a slice; the other codes are those of [`ErrorKind`].
const NOTHING: c_int = 9;

/// Handle of a subscription.
#[derive(Debug)]
pub struct KosekiSubscription(Box<dyn AnySubscription>);

/// Handle of a publisher.
#[derive(Debug)]
pub struct KosekiPublisher(Box<dyn AnyPublisher>);

/// Slice protected from being overwritten until its release.
#[derive(Debug)]
#[repr(C)]
pub struct KosekiSlice {
    samples: *const c_void,
    count: usize,
    header: *const BatchHeader,
    lost: u64,
    starts_epoch: c_int,
    handle: *mut Box<dyn AnySlice>,
}

/// Counts of a subscription.
#[derive(Debug)]
#[repr(C)]
pub struct KosekiCounts {
    taken: u64,
    lost: u64,
    of_older_epochs: u64,
    epoch: u64,
}

thread_local! {
    static LATEST: RefCell<CString> = RefCell::default();
}

fn failed(kind: ErrorKind, text: String) -> c_int {
    let text = CString::new(text.replace('\0', "?")).unwrap_or_default();
    LATEST.set(text);
    kind as c_int
}

fn code(done: Result<c_int, Error>) -> c_int {
    done.unwrap_or_else(|error| failed(error.kind(), error.to_string()))
}

/// Returns the text at `text`, or an error code if it is invalid.
///
/// # Safety
/// `text` is null or a string that ends with a zero.
unsafe fn word<'a>(text: *const c_char, name: &str) -> Result<&'a str, c_int> {
    if text.is_null() {
        return Err(failed(ErrorKind::Argument, format!("{name} is null")));
    }
    // SAFETY: guaranteed by the caller, as stated above.
    let text = unsafe { CStr::from_ptr(text) }.to_str();
    text.map_err(|error| failed(ErrorKind::Argument, format!("{name}: {error}")))
}

/// Checks that the samples of the caller's header match those of this library.
fn check_schema(stated: u64, layout: &Layout) -> Result<(), c_int> {
    if stated == layout.fingerprint() {
        return Ok(());
    }
    let text = format!(
        "{}: the header states schema {stated:#x}, the library has {:#x}: compile with the library's own koseki.h, and \
         ask for the schema of the topic's type",
        layout.name,
        layout.fingerprint()
    );
    Err(failed(ErrorKind::Schema, text))
}

/// Opens `topic` in the deployment `instance`, and stores the new handle in `handle`.
///
/// # Safety
/// The texts are null or end with a zero; `handle` is null or can be written to.
unsafe fn open<T, H>(
    instance: *const c_char,
    topic: *const c_char,
    handle: *mut *mut H,
    open: impl FnOnce(&Root, &str) -> Result<T, Error>,
    finish: impl FnOnce(T) -> Result<H, c_int>,
) -> c_int {
    let opened = || {
        if handle.is_null() {
            return Err(failed(
                ErrorKind::Argument,
                "the place of the handle is null".to_owned(),
            ));
        }
        // SAFETY: `handle` is not null, and the caller guarantees that it can be written to.
        unsafe { *handle = ptr::null_mut() };
        // SAFETY: guaranteed by the caller, as stated above.
        let (instance, topic) = unsafe { (word(instance, "instance")?, word(topic, "topic")?) };
        let root = Root::new(instance).map_err(Error::from);
        let opened = root.and_then(|root| open(&root, topic));
        finish(opened.map_err(|error| failed(error.kind(), error.to_string()))?)
    };
    match opened() {
        Ok(opened) => {
            // SAFETY: checked above.
            unsafe { *handle = Box::into_raw(Box::new(opened)) };
            OK
        }
        Err(code) => code,
    }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_subscribe(
    instance: *const c_char,
    topic: *const c_char,
    schema: u64,
    handle: *mut *mut KosekiSubscription,
) -> c_int {
    // SAFETY: the contract of the header.
    unsafe { subscribe(instance, topic, schema, None, handle) }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_subscribe_with_queue(
    instance: *const c_char,
    topic: *const c_char,
    schema: u64,
    queue: usize,
    handle: *mut *mut KosekiSubscription,
) -> c_int {
    // SAFETY: the contract of the header.
    unsafe { subscribe(instance, topic, schema, Some(queue), handle) }
}

/// Opens a subscription with a queue of `queue` slices; `None` is the topic's usual number.
///
/// # Safety
/// As for [`open`].
unsafe fn subscribe(
    instance: *const c_char,
    topic: *const c_char,
    schema: u64,
    queue: Option<usize>,
    handle: *mut *mut KosekiSubscription,
) -> c_int {
    let checked = |opened: Box<dyn AnySubscription>| {
        check_schema(schema, opened.layout())?;
        Ok(KosekiSubscription(opened))
    };
    let by_name = |root: &Root, topic: &str| by_name::subscribe(root, topic, queue);
    // SAFETY: guaranteed by the caller.
    unsafe { open(instance, topic, handle, by_name, checked) }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_receive(
    subscription: *mut KosekiSubscription,
    timeout_ms: i64,
    slice: *mut KosekiSlice,
) -> c_int {
    // SAFETY: the header requires an open handle, used by one thread at a time, and a writable place.
    let (Some(subscription), false) = (unsafe { subscription.as_mut() }, slice.is_null()) else {
        return failed(ErrorKind::Argument, "subscription or slice is null".to_owned());
    };
    let empty = KosekiSlice {
        samples: ptr::null(),
        count: 0,
        header: ptr::null(),
        lost: 0,
        starts_epoch: 0,
        handle: ptr::null_mut(),
    };
    // SAFETY: as above; the overwritten value needs no drop.
    unsafe { slice.write(empty) };
    let timeout = u64::try_from(timeout_ms).map_or(Duration::MAX, Duration::from_millis);
    let size = subscription.0.layout().size;
    code(subscription.0.next(timeout).map(|next| match next {
        None => NOTHING,
        Some(next) => {
            let octets = next.octets();
            let taken = KosekiSlice {
                samples: octets.as_ptr().cast(),
                count: octets.len() / size,
                header: next.header(),
                lost: next.lost(),
                starts_epoch: next.starts_epoch().into(),
                handle: Box::into_raw(Box::new(next)),
            };
            // SAFETY: as above.
            unsafe { slice.write(taken) };
            OK
        }
    }))
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_release(slice: *mut KosekiSlice) {
    // SAFETY: the header requires null or a slice written by `koseki_receive`.
    let Some(slice) = (unsafe { slice.as_mut() }) else {
        return;
    };
    let handle = std::mem::replace(&mut slice.handle, ptr::null_mut());
    (slice.samples, slice.header, slice.count) = (ptr::null(), ptr::null(), 0);
    if !handle.is_null() {
        // SAFETY: the pointer comes from `Box::into_raw`, and has just been taken out of its only place.
        drop(unsafe { Box::from_raw(handle) });
    }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_descriptor(subscription: *const KosekiSubscription) -> c_int {
    // SAFETY: the header requires null or an open handle.
    let subscription = unsafe { subscription.as_ref() };
    subscription.map_or(-1, |subscription| subscription.0.as_fd().as_raw_fd())
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_counts(subscription: *const KosekiSubscription) -> KosekiCounts {
    // SAFETY: the header requires null or an open handle.
    let subscription = unsafe { subscription.as_ref() };
    let counts = subscription
        .map(|subscription| subscription.0.counts())
        .unwrap_or_default();
    KosekiCounts {
        taken: counts.taken,
        lost: counts.lost,
        of_older_epochs: counts.of_older_epochs,
        epoch: counts.epoch,
    }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_unsubscribe(subscription: *mut KosekiSubscription) {
    if !subscription.is_null() {
        // SAFETY: the header requires an open handle, which comes from `Box::into_raw`.
        drop(unsafe { Box::from_raw(subscription) });
    }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_advertise(
    instance: *const c_char,
    topic: *const c_char,
    schema: u64,
    handle: *mut *mut KosekiPublisher,
) -> c_int {
    let checked = |opened: Box<dyn AnyPublisher>| {
        check_schema(schema, opened.layout())?;
        Ok(KosekiPublisher(opened))
    };
    // SAFETY: the contract of the header.
    unsafe { open(instance, topic, handle, by_name::publisher, checked) }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_publish(
    publisher: *mut KosekiPublisher,
    samples: *const c_void,
    count: usize,
) -> c_int {
    // SAFETY: the header requires an open handle, used by one thread at a time.
    let (Some(publisher), false) = (unsafe { publisher.as_mut() }, samples.is_null()) else {
        return failed(ErrorKind::Argument, "publisher or samples are null".to_owned());
    };
    let Some(length) = count.checked_mul(publisher.0.layout().size) else {
        return failed(
            ErrorKind::Argument,
            format!("{count} samples are more than memory holds"),
        );
    };
    // SAFETY: the header requires `count` samples of the publisher's type, whose bytes are all fields.
    let octets = unsafe { std::slice::from_raw_parts(samples.cast::<u8>(), length) };
    code(publisher.0.publish(octets).map(|()| OK))
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_limit_clock(publisher: *mut KosekiPublisher, limit_s: f64) -> c_int {
    // SAFETY: the header requires null or an open handle, used by one thread at a time.
    let Some(publisher) = (unsafe { publisher.as_mut() }) else {
        return failed(ErrorKind::Argument, "publisher is null".to_owned());
    };
    match by_name::clock_limit(limit_s) {
        Ok(limit) => publisher.0.limit_clock(limit),
        Err(error) => return failed(error.kind(), error.to_string()),
    }
    OK
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_unadvertise(publisher: *mut KosekiPublisher) {
    if !publisher.is_null() {
        // SAFETY: the header requires an open handle, which comes from `Box::into_raw`.
        drop(unsafe { Box::from_raw(publisher) });
    }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_order(
    instance: *const c_char,
    order: *const c_char,
    operator_name: *const c_char,
    lasts_s: f64,
    timeout_ms: i64,
    state: *mut OrderState,
) -> c_int {
    let given = || {
        // SAFETY: the header requires texts that end with a zero.
        let (instance, order) = unsafe { (word(instance, "instance")?, word(order, "order")?) };
        // SAFETY: as above.
        let operator = unsafe { word(operator_name, "operator_name")? };
        let timeout = u64::try_from(timeout_ms).map_or(Duration::MAX, Duration::from_millis);
        let lasts_s = (lasts_s > 0.0).then_some(lasts_s);
        let answer = Orders::open(instance, operator).and_then(|mut orders| {
            let order = orders.of_words(order)?;
            orders.give(&order, lasts_s, timeout)
        });
        answer.map_err(|error| failed(error.kind(), error.to_string()))
    };
    match given() {
        Ok(Some(answer)) => {
            if !state.is_null() {
                // SAFETY: the header requires null or a place that can be written to.
                unsafe { state.write(answer) };
            }
            OK
        }
        Ok(None) => {
            failed(ErrorKind::System, "fusion has not answered in time".to_owned());
            NOTHING
        }
        Err(code) => code,
    }
}

/// See the header.
#[unsafe(no_mangle)]
pub extern "C" fn koseki_error() -> *const c_char {
    // The text stays in place until this thread's next failure replaces it.
    LATEST.with_borrow(|text| text.as_ptr())
}
