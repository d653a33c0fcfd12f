//! A channel that hands a copy of all that passes to a recorder, and is otherwise the channel in it.

use std::time::Duration;

use protocol::Error;
use protocol::channel::{Channel, Loan, Received, Wait};
use protocol::codec;
use protocol::field::Field;
use protocol::header::{FieldHeader, Stage};
use protocol::message::{Role, ToCoupler, ToEngine};

use crate::entry::Kind;

use super::feed::{Feed, Payload};

/// The coupler's end of a link, recorded. Copies are made after sending, while the engine works.
pub(crate) struct Tap {
    pub(crate) inner: Box<dyn Channel>,
    pub(crate) role: Role,
    pub(crate) feed: Feed,
}

impl Tap {
    fn field(&self, field: Field, header: FieldHeader, values: &[f64]) {
        self.feed.take(
            self.role,
            Kind::Field(field),
            header,
            values.len() * 8,
            || Payload::Numbers(values.to_vec()),
        );
    }

    fn message(&self, kind: Kind, header: FieldHeader, bytes: &[u8]) {
        self.feed.take(self.role, kind, header, bytes.len(), || {
            Payload::Bytes(bytes.to_vec())
        });
    }

    fn answer(&self, (header, bytes): &(FieldHeader, Vec<u8>)) {
        match without_token(header, bytes) {
            Some((header, bytes)) => self.message(Kind::Answer, header, &bytes),
            None => self.message(Kind::Answer, *header, bytes),
        }
    }
}

/// A hello whose token is blank: whoever gets the recording cannot join a run with it.
fn without_token(header: &FieldHeader, bytes: &[u8]) -> Option<(FieldHeader, Vec<u8>)> {
    // Messages of other kinds are not decoded for this.
    const HELLO: u8 = 0;
    bytes.first().filter(|&&kind| kind == HELLO)?;
    let Ok(ToCoupler::Hello(mut hello)) = codec::decode(bytes) else {
        return None;
    };
    hello.token = None;
    let blank = codec::encode(&ToCoupler::Hello(hello)).ok()?;
    let count = blank.len() as u64;
    Some((FieldHeader { count, ..*header }, blank))
}

impl Channel for Tap {
    fn peer(&self) -> &str {
        self.inner.peer()
    }

    fn send_message(&mut self, header: FieldHeader, bytes: &[u8]) -> Result<bool, Error> {
        let sent = self.inner.send_message(header, bytes)?;
        if sent {
            let message = codec::decode(bytes);
            let advance = matches!(message, Ok(ToEngine::Advance(_)));
            // a mesh belongs to the step before which it was asked for
            if advance || matches!(message, Ok(ToEngine::Adapt { .. })) {
                self.feed.enter(self.role, header.step, header.pass);
            }
            self.message(Kind::Request, header, bytes);
            if advance {
                self.feed.asked(self.role, header.pass);
            }
        }
        Ok(sent)
    }

    fn poll_message(&mut self) -> Result<Option<(FieldHeader, Vec<u8>)>, Error> {
        let message = self.inner.poll_message()?;
        if let Some(message) = &message {
            self.answer(message);
        }
        Ok(message)
    }

    fn receive_message(&mut self, wait: Wait<'_>) -> Result<(FieldHeader, Vec<u8>), Error> {
        let message = self.inner.receive_message(wait)?;
        self.answer(&message);
        Ok(message)
    }

    fn loan_field(&mut self, field: Field, header: FieldHeader) -> Result<Box<dyn Loan>, Error> {
        Ok(Box::new(TappedLoan {
            inner: self.inner.loan_field(field, header)?,
            role: self.role,
            field,
            header,
            feed: self.feed.clone(),
        }))
    }

    fn send_field(
        &mut self,
        field: Field,
        header: FieldHeader,
        values: &[f64],
    ) -> Result<(), Error> {
        self.inner.send_field(field, header, values)?;
        if header.stage == Stage::Advance as u32 {
            self.feed.enter(self.role, header.step, header.pass);
        }
        self.field(field, header, values);
        Ok(())
    }

    fn receive_field(&mut self, field: Field, wait: Wait<'_>) -> Result<Box<dyn Received>, Error> {
        let received = self.inner.receive_field(field, wait)?;
        self.field(field, *received.header(), received.values());
        Ok(received)
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

/// A buffer that is copied when it is sent.
struct TappedLoan {
    inner: Box<dyn Loan>,
    role: Role,
    field: Field,
    header: FieldHeader,
    feed: Feed,
}

impl Loan for TappedLoan {
    fn values(&mut self) -> &mut [f64] {
        self.inner.values()
    }

    fn send(mut self: Box<Self>) -> Result<(), Error> {
        if self.header.stage == Stage::Advance as u32 {
            self.feed
                .enter(self.role, self.header.step, self.header.pass);
        }
        // After sending, the buffer belongs to the receiver.
        let values = self.inner.values();
        let (kind, bytes) = (Kind::Field(self.field), values.len() * 8);
        self.feed.take(self.role, kind, self.header, bytes, || {
            Payload::Numbers(values.to_vec())
        });
        self.inner.send()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::PROTOCOL_VERSION;
    use protocol::message::Hello;

    #[test]
    fn a_recording_does_not_tell_the_token_of_its_run() {
        let mut hello = Hello {
            role: Role::Fluid,
            engine: "odd".to_owned(),
            version: "0".to_owned(),
            protocol: PROTOCOL_VERSION,
            process: 1,
            capabilities: Vec::new(),
            token: Some("secret".to_owned()),
        };
        let bytes = codec::encode(&ToCoupler::Hello(hello.clone())).expect("small");
        let header = FieldHeader::message(0, 0, bytes.len());
        let (header, blank) = without_token(&header, &bytes).expect("a hello");
        hello.token = None;
        assert_eq!(header.count, blank.len() as u64);
        assert_eq!(codec::decode(&blank), Ok(ToCoupler::Hello(hello)));
        let stored = codec::encode(&ToCoupler::Stored).expect("small");
        let header = FieldHeader::message(0, 0, stored.len());
        assert!(without_token(&header, &stored).is_none());
    }
}
