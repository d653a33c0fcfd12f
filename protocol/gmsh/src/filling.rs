//! Elements that fill the domain: of the surfaces that a scene names, each once.

use std::collections::{BTreeMap, BTreeSet};

use crate::error::Faults;
use crate::file::{Element, File};
use crate::mesh::Options;

/// Elements that fill the domain, with what the file says of them, each once.
pub(crate) struct Filling<'a> {
    pub(crate) elements: Vec<(&'a Element, Vec<String>)>,
}

impl<'a> Filling<'a> {
    /// The elements of the surfaces that the scene names, or of the only one.
    pub(crate) fn of<const D: usize>(
        file: &'a File,
        options: &Options,
        faults: &mut Faults,
    ) -> Filling<'a> {
        let solids = file
            .elements
            .iter()
            .filter(|element| element.dimension == D);
        let mut filling = Filling {
            elements: Vec::new(),
        };
        let mut known: BTreeMap<Vec<u64>, usize> = BTreeMap::new();
        let mut there = BTreeSet::new();
        for element in solids {
            let labels = file.labels(element);
            there.extend(labels.iter().cloned());
            let wanted = |label: &String| options.surfaces.contains(label);
            if options.surfaces.is_empty() || labels.iter().any(wanted) {
                filling.add(element, labels, &mut known, faults);
            }
        }
        let measure = ["surface", "volume"][D - 2];
        for missing in options
            .surfaces
            .iter()
            .filter(|name| !there.contains(*name))
        {
            let there: Vec<&String> = there.iter().collect();
            faults.note(format!(
                "no {measure} is called {missing:?}; there are {there:?}"
            ));
        }
        if let Some(volume) = file.elements.iter().find(|element| element.dimension > D) {
            let number = volume.number;
            faults.note(format!(
                "element {number} is a volume; the mesh of a scene of the plane must be plane, and in space gravity has three \
                 numbers"
            ));
        }
        filling
    }

    /// Take an element. Format 2.2 writes it once for each of its groups.
    fn add(
        &mut self,
        element: &'a Element,
        labels: Vec<String>,
        known: &mut BTreeMap<Vec<u64>, usize>,
        faults: &mut Faults,
    ) {
        let mut nodes = element.nodes[..element.corners].to_vec();
        nodes.sort_unstable();
        match known.get(&nodes) {
            Some(&at) if self.elements[at].1 != labels && element.group.is_some() => {
                let all = &mut self.elements[at].1;
                all.extend(labels);
                all.sort();
                all.dedup();
            }
            Some(&at) => {
                let (one, other) = (self.elements[at].0.number, element.number);
                faults.note(format!("elements {one} and {other} have the same nodes"));
            }
            None => {
                known.insert(nodes, self.elements.len());
                self.elements.push((element, labels));
            }
        }
    }
}
