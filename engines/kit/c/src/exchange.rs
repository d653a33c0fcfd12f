//! The fields of one advance(): an engine asks for each by its number.

use protocol::engine;
use protocol::field::Field;

/// Fields that came with a request; valid until advance() returns.
pub struct Inputs {
    fields: Vec<(Field, *const f64)>,
}

/// Fields of the candidate, to be filled; valid until advance() returns.
pub struct Outputs {
    fields: Vec<(Field, *mut f64)>,
}

impl Inputs {
    pub(crate) fn of(inputs: &engine::Inputs<'_>) -> Inputs {
        let fields = inputs.all().iter();
        Inputs {
            fields: fields
                .map(|(field, values)| (*field, values.as_ptr()))
                .collect(),
        }
    }
}

impl Outputs {
    /// The room, and how many nodes or grains it is for.
    pub(crate) fn of(outputs: engine::Outputs<'_>, dimension: usize) -> (Outputs, usize) {
        let all = outputs.into_all().into_iter();
        let mut count = 0;
        let fields = all.map(|(field, room)| {
            count = room.len() / field.components(dimension);
            (field, room.as_mut_ptr())
        });
        let fields = fields.collect();
        (Outputs { fields }, count)
    }
}

/// The numbers of an input, one of SILLAGE_FIELD_...: a scalar has `count` numbers, a vector
/// `count * dimension`. NULL: it was not sent, and is 0 everywhere (porosity: 1).
///
/// # Safety
///
/// `inputs` is what advance() was called with, and advance() has not returned.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_input(inputs: *const Inputs, field: u32) -> *const f64 {
    // SAFETY: as the caller promises.
    let inputs = unsafe { inputs.as_ref() };
    let found = inputs.and_then(|inputs| find(&inputs.fields, field));
    found.unwrap_or(std::ptr::null())
}

/// Room for a field of the candidate, one of SILLAGE_FIELD_...: every number is NaN before, and refused
/// if it stays so. NULL: this field is not of a candidate. Particles fill SILLAGE_FIELD_GRAIN_POSITION,
/// _VELOCITY, _MEAN_VELOCITY and _CONTACT, a fluid SILLAGE_FIELD_INTERSTITIAL_VELOCITY,
/// _PRESSURE_GRADIENT and _PRESSURE.
///
/// # Safety
///
/// `outputs` is what advance() was called with, and advance() has not returned.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_output(outputs: *const Outputs, field: u32) -> *mut f64 {
    // SAFETY: as the caller promises.
    let outputs = unsafe { outputs.as_ref() };
    let found = outputs.and_then(|outputs| find(&outputs.fields, field));
    found.unwrap_or(std::ptr::null_mut())
}

fn find<T: Copy>(fields: &[(Field, T)], wanted: u32) -> Option<T> {
    let found = fields.iter().find(|(field, _)| field.id() == wanted);
    found.map(|&(_, place)| place)
}
