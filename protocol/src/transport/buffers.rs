//! Fields in the transport's own buffers: one that will be sent, and one that came.

use std::sync::Arc;

use iceoryx2::sample::Sample;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::Service;

use super::ends::End;
use super::services::delivered;
use crate::language::error::Error;
use crate::language::field::Field;
use crate::language::header::{FieldHeader, check_sum};
use crate::run::liveness::Board;
use crate::transport::channel::{Loan, Received};

/// A buffer that will be sent.
pub(super) struct Loaned<S: Service> {
    pub(super) sample: SampleMut<S, [f64], FieldHeader>,
    pub(super) field: Field,
    pub(super) check: bool,
    pub(super) end: End,
    pub(super) board: Arc<Board>,
}

impl<S: Service> Loan for Loaned<S> {
    fn values(&mut self) -> &mut [f64] {
        self.sample.payload_mut()
    }

    fn send(mut self: Box<Self>) -> Result<(), Error> {
        if self.check {
            self.sample.user_header_mut().check = check_sum(self.sample.payload());
        }
        let Loaned {
            sample,
            field,
            end,
            board,
            ..
        } = *self;
        let step = sample.user_header().step;
        delivered(field.name(), step, &end, &board, sample.send())
    }
}

/// A buffer that came.
pub(super) struct Arrived<S: Service> {
    pub(super) sample: Sample<S, [f64], FieldHeader>,
}

impl<S: Service> Received for Arrived<S> {
    fn header(&self) -> &FieldHeader {
        self.sample.user_header()
    }

    fn values(&self) -> &[f64] {
        self.sample.payload()
    }
}
