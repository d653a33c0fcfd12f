//! A link whose buffers are never given back while an engine still looks at them.
//!
//! That is an error of the engine and ends the run; but a view that points to memory that is gone
//! would end the process without a word. What is held is never freed: the run is over anyway.

use std::cell::Cell;
use std::mem::ManuallyDrop;
use std::rc::Rc;
use std::time::Duration;

use protocol::channel::{Channel, Loan, Received, Wait};
use protocol::error::Error;
use protocol::field::Field;
use protocol::header::FieldHeader;

/// Set when an engine keeps a view: from then on no buffer is given back.
pub type Escaped = Rc<Cell<bool>>;

/// The link of an engine.
pub struct HeldLink {
    /// The transport.
    pub inner: Box<dyn Channel>,
    /// Shared with the engine's bridge.
    pub escaped: Escaped,
}

/// A buffer and whether it may be given back.
struct Held<T> {
    buffer: ManuallyDrop<T>,
    escaped: Escaped,
}

impl<T> Held<T> {
    fn new(buffer: T, escaped: &Escaped) -> Held<T> {
        Held {
            buffer: ManuallyDrop::new(buffer),
            escaped: Rc::clone(escaped),
        }
    }
}

impl<T> Drop for Held<T> {
    fn drop(&mut self) {
        if !self.escaped.get() {
            // SAFETY: dropped once, here; `send`, which takes the buffer out, forgets `self`.
            unsafe { ManuallyDrop::drop(&mut self.buffer) }
        }
    }
}

impl Received for Held<Box<dyn Received>> {
    fn header(&self) -> &FieldHeader {
        self.buffer.header()
    }

    fn values(&self) -> &[f64] {
        self.buffer.values()
    }
}

impl Loan for Held<Box<dyn Loan>> {
    fn values(&mut self) -> &mut [f64] {
        self.buffer.values()
    }

    fn send(mut self: Box<Self>) -> Result<(), Error> {
        // SAFETY: `self` is forgotten below, so the buffer is neither used nor dropped again.
        let buffer = unsafe { ManuallyDrop::take(&mut self.buffer) };
        // The shared flag alone is still to be dropped.
        // SAFETY: read once, from a value that is forgotten.
        drop(unsafe { std::ptr::read(&raw const self.escaped) });
        std::mem::forget(self);
        buffer.send()
    }
}

impl Channel for HeldLink {
    fn peer(&self) -> &str {
        self.inner.peer()
    }

    fn send_message(&mut self, header: FieldHeader, bytes: &[u8]) -> Result<bool, Error> {
        self.inner.send_message(header, bytes)
    }

    fn poll_message(&mut self) -> Result<Option<(FieldHeader, Vec<u8>)>, Error> {
        self.inner.poll_message()
    }

    fn receive_message(&mut self, wait: Wait<'_>) -> Result<(FieldHeader, Vec<u8>), Error> {
        self.inner.receive_message(wait)
    }

    fn loan_field(&mut self, field: Field, header: FieldHeader) -> Result<Box<dyn Loan>, Error> {
        let loan = self.inner.loan_field(field, header)?;
        Ok(Box::new(Held::new(loan, &self.escaped)))
    }

    fn send_field(
        &mut self,
        field: Field,
        header: FieldHeader,
        values: &[f64],
    ) -> Result<(), Error> {
        self.inner.send_field(field, header, values)
    }

    fn receive_field(&mut self, field: Field, wait: Wait<'_>) -> Result<Box<dyn Received>, Error> {
        let received = self.inner.receive_field(field, wait)?;
        Ok(Box::new(Held::new(received, &self.escaped)))
    }

    fn idle(&mut self, wait: Wait<'_>, limit: Duration) -> Result<(), Error> {
        self.inner.idle(wait, limit)
    }

    fn wait_for_leave(&mut self, limit: Duration) -> bool {
        self.inner.wait_for_leave(limit)
    }

    fn has_reader(&mut self) -> Result<bool, Error> {
        self.inner.has_reader()
    }

    fn culprit(&mut self) -> String {
        self.inner.culprit()
    }

    fn anyone_is_lost(&self) -> bool {
        self.inner.anyone_is_lost()
    }

    fn peer_is_gone(&self) -> bool {
        self.inner.peer_is_gone()
    }

    fn token(&self) -> Option<&str> {
        self.inner.token()
    }
}
