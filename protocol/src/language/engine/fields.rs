//! The fields of one request as an engine sees them: in place in the transport's memory, by their row of
//! the table.

use crate::language::field::Field;

/// Fields that came with a request.
#[derive(Debug, Clone, Copy, Default)]
pub struct Inputs<'a> {
    fields: &'a [(Field, &'a [f64])],
}

impl<'a> Inputs<'a> {
    /// These fields.
    pub fn new(fields: &'a [(Field, &'a [f64])]) -> Inputs<'a> {
        Inputs { fields }
    }

    /// The numbers of a field; none: it did not come, and has its default (`Field::spec`) everywhere.
    pub fn get(&self, field: Field) -> Option<&'a [f64]> {
        let found = self.fields.iter().find(|(given, _)| *given == field);
        found.map(|&(_, values)| values)
    }

    /// All that came.
    pub fn all(&self) -> &'a [(Field, &'a [f64])] {
        self.fields
    }
}

/// Fields of a candidate, to be filled: every number is NaN before, and refused if it stays so.
#[derive(Debug)]
pub struct Outputs<'a> {
    fields: Vec<(Field, &'a mut [f64])>,
}

impl<'a> Outputs<'a> {
    /// Room for these fields.
    pub fn new(fields: Vec<(Field, &'a mut [f64])>) -> Outputs<'a> {
        Outputs { fields }
    }

    /// The room for a field, once; empty for one that is not of a candidate.
    pub fn take(&mut self, field: Field) -> &'a mut [f64] {
        let place = self.fields.iter().position(|(given, _)| *given == field);
        place.map_or(&mut [], |place| self.fields.swap_remove(place).1)
    }

    /// The same room for a shorter while: for an engine around another one.
    pub fn reborrow(&mut self) -> Outputs<'_> {
        let fields = self.fields.iter_mut();
        Outputs::new(fields.map(|(field, room)| (*field, &mut **room)).collect())
    }

    /// All of it.
    pub fn into_all(self) -> Vec<(Field, &'a mut [f64])> {
        self.fields
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_by_name_and_room_is_given_once() {
        let values = [1.0, 2.0];
        let given = [(Field::Porosity, values.as_slice())];
        let inputs = Inputs::new(&given);
        assert_eq!(inputs.get(Field::Porosity), Some(values.as_slice()));
        assert_eq!(inputs.get(Field::Drag), None);
        let (mut velocity, mut pressure) = ([0.0; 4], [0.0; 2]);
        let mut outputs = Outputs::new(vec![
            (Field::InterstitialVelocity, &mut velocity[..]),
            (Field::Pressure, &mut pressure[..]),
        ]);
        outputs.take(Field::InterstitialVelocity).fill(3.0);
        assert!(outputs.take(Field::InterstitialVelocity).is_empty());
        assert!(outputs.take(Field::Porosity).is_empty());
        assert_eq!(outputs.into_all().len(), 1);
        assert_eq!(velocity, [3.0; 4]);
    }
}
