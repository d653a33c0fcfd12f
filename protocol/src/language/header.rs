//! The 64 bytes that travel with every field and every message, and their validation.
//!
//! Another program wrote them: nothing is used before it was compared with what is expected.

use iceoryx2::prelude::ZeroCopySend;

use super::error::Error;
use super::field::Field;

/// Version of the messages and of the header; both sides of a link must agree on it.
pub const PROTOCOL_VERSION: u32 = 2;

/// Where in the exchange a message or field belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Stage {
    /// Control messages.
    Message = 0,
    /// Initial grains, with `Configure`.
    Configure = 1,
    /// Mesh or grains, with `Ready`.
    Ready = 2,
    /// Inputs of a candidate, with `Advance`.
    Advance = 3,
    /// The candidate, with `Done`.
    Done = 4,
    /// Mesh and radii for the orchestrator, with `Started`.
    Started = 5,
    /// The accepted state for the orchestrator, with `Snapshot`.
    Snapshot = 6,
}

/// Header of a field or message: 64 bytes, native (little) endian, no padding.
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("SillageHeader2")]
#[repr(C)]
pub struct FieldHeader {
    /// `PROTOCOL_VERSION` (byte 0).
    pub protocol: u32,
    /// `Field::id`, 0 for a control message (byte 4).
    pub field: u32,
    /// Epoch of the mesh or of the grains, from `Ready`; 0 before it (byte 8).
    pub epoch: u64,
    /// Step, 0 outside of steps (byte 16).
    pub step: u64,
    /// Pass within the step (byte 24).
    pub pass: u32,
    /// [`Stage`] (byte 28).
    pub stage: u32,
    /// Numbers for each node, simplex or grain; 1 for a control message (byte 32).
    pub components: u32,
    /// 0 (byte 36).
    pub reserved: u32,
    /// Numbers in the payload (bytes for a control message), all components together (byte 40).
    pub count: u64,
    /// Time of the values \[s\]: start of the step with `Advance`, its end with `Done` (byte 48).
    pub time: f64,
    /// [`check_sum`] of the payload, or 0: not computed (byte 56).
    pub check: u64,
}

/// What a receiver knows about the field that must come next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// The field.
    pub field: Field,
    /// Epoch of its mesh or grains.
    pub epoch: u64,
    /// Step.
    pub step: u64,
    /// Pass.
    pub pass: u32,
    /// Stage.
    pub stage: Stage,
    /// Dimension of the space: how many numbers a vector has.
    pub dimension: usize,
    /// Nodes, simplices or grains (not multiplied by the components).
    pub entities: usize,
    /// Time of the values \[s\].
    pub time: f64,
}

impl Expected {
    /// Numbers in the payload.
    pub fn count(&self) -> usize {
        self.entities * self.field.components(self.dimension)
    }

    /// The header that a sender writes.
    pub fn header(&self) -> FieldHeader {
        FieldHeader {
            protocol: PROTOCOL_VERSION,
            field: self.field.id(),
            epoch: self.epoch,
            step: self.step,
            pass: self.pass,
            stage: self.stage as u32,
            components: self.field.components(self.dimension) as u32,
            reserved: 0,
            count: self.count() as u64,
            time: self.time,
            check: 0,
        }
    }
}

impl FieldHeader {
    /// The header of a control message of `length` bytes.
    pub fn message(step: u64, pass: u32, length: usize) -> FieldHeader {
        FieldHeader {
            protocol: PROTOCOL_VERSION,
            step,
            pass,
            stage: Stage::Message as u32,
            components: 1,
            count: length as u64,
            ..FieldHeader::default()
        }
    }

    /// Compare every value of a control message's header with what it must be.
    pub fn validate_message(&self, who: &str, length: usize) -> Result<(), Error> {
        if self.protocol != PROTOCOL_VERSION {
            return Err(other_protocol(who, self.protocol));
        }
        let wrong = |name, value: u64, expected: u64| {
            wrong_value(who, self.step, "message", name, value, expected)
        };
        if self.field != 0 || self.stage != Stage::Message as u32 {
            return Err(wrong(
                "field and stage",
                self.field.max(self.stage).into(),
                0,
            ));
        }
        if self.components != 1 || self.reserved != 0 {
            return Err(wrong(
                "components + reserved",
                u64::from(self.components) + u64::from(self.reserved),
                1,
            ));
        }
        if self.count != length as u64 {
            return Err(wrong("count", self.count, length as u64));
        }
        Ok(())
    }

    /// Compare every value with what must come next from `who`, and look at every number: NaN and
    /// infinities are refused with their place.
    pub fn validate(&self, who: &str, expected: &Expected, payload: &[f64]) -> Result<(), Error> {
        self.validate_values(who, expected, payload.len())?;
        if self.check != 0 && self.check != check_sum(payload) {
            return Err(wrong_value(
                who,
                expected.step,
                expected.field.name(),
                "check",
                self.check,
                check_sum(payload),
            ));
        }
        let field = (expected.field, expected.dimension);
        require_finite(who, expected.step, field, payload)
    }

    fn validate_values(&self, who: &str, expected: &Expected, length: usize) -> Result<(), Error> {
        if self.protocol != PROTOCOL_VERSION {
            return Err(other_protocol(who, self.protocol));
        }
        let must = expected.header();
        let pairs: [(&str, u64, u64); 9] = [
            ("field", self.field.into(), must.field.into()),
            ("epoch", self.epoch, must.epoch),
            ("step", self.step, must.step),
            ("pass", self.pass.into(), must.pass.into()),
            ("stage", self.stage.into(), must.stage.into()),
            ("components", self.components.into(), must.components.into()),
            ("reserved", self.reserved.into(), 0),
            ("count", self.count, must.count),
            ("count against the payload", self.count, length as u64),
        ];
        for (name, value, bound) in pairs {
            if value != bound {
                return Err(wrong_value(
                    who,
                    expected.step,
                    expected.field.name(),
                    name,
                    value,
                    bound,
                ));
            }
        }
        if self.time.to_bits() != must.time.to_bits() {
            let why = format!("time is {} s, expected {} s", self.time, must.time);
            return Err(Error::invalid(
                who,
                expected.step,
                header_of(expected.field.name()),
                why,
            ));
        }
        Ok(())
    }
}

fn header_of(name: &str) -> String {
    format!("header of {name}")
}

fn wrong_value(who: &str, step: u64, of: &str, name: &str, value: u64, expected: u64) -> Error {
    Error::invalid(
        who,
        step,
        header_of(of),
        format!("{name} is {value}, expected {expected}"),
    )
}

pub(crate) fn other_protocol(who: &str, theirs: u32) -> Error {
    Error::Handshake {
        who: who.to_owned(),
        why: format!("it speaks protocol {theirs}, this process speaks {PROTOCOL_VERSION}"),
    }
}

/// Refuse the first NaN or infinity of a field in a space of this dimension, with field, node or grain,
/// component, sender and step.
pub fn require_finite(
    who: &str,
    step: u64,
    (field, dimension): (Field, usize),
    values: &[f64],
) -> Result<(), Error> {
    const BLOCK: usize = 64;
    for (block, chunk) in values.chunks(BLOCK).enumerate() {
        // Without an early exit inside a block this is a vector loop.
        if chunk
            .iter()
            .fold(false, |bad, value| bad | !value.is_finite())
        {
            let within = chunk
                .iter()
                .position(|value| !value.is_finite())
                .unwrap_or(0);
            let place = block * BLOCK + within;
            return Err(Error::NotFinite {
                who: who.to_owned(),
                step,
                field,
                support: field.support().name(),
                index: place / field.components(dimension),
                component: place % field.components(dimension),
                value: values[place].to_string(),
            });
        }
    }
    Ok(())
}

/// Check sum of a payload, never 0: the bits of each number multiplied by an odd constant (Knuth's
/// 2⁶⁴/φ) and rotated into one of four lanes, lanes combined in order.
pub fn check_sum(values: &[f64]) -> u64 {
    const ODD: u64 = 0x9E37_79B9_7F4A_7C15;
    let mix = |lane: u64, value: f64| (lane.rotate_left(5) ^ value.to_bits()).wrapping_mul(ODD);
    let mut lanes = [1_u64, 2, 3, 4];
    let mut quads = values.chunks_exact(4);
    for quad in &mut quads {
        for (lane, &value) in lanes.iter_mut().zip(quad) {
            *lane = mix(*lane, value);
        }
    }
    for (lane, &value) in lanes.iter_mut().zip(quads.remainder()) {
        *lane = mix(*lane, value);
    }
    let sum = lanes.iter().fold(values.len() as u64, |sum, &lane| {
        (sum.rotate_left(17) ^ lane).wrapping_mul(ODD)
    });
    sum.max(1)
}
