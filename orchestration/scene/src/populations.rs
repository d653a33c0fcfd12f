//! Ranges of the grain populations of a scene.

use space::Dim;

use crate::check::Checker;
use crate::dimensions::Scenic;
use crate::keys::{Arrangement, Grains, Radius};

impl Checker<'_> {
    pub(crate) fn population<const D: usize>(&mut self, key: &str, grains: &Grains<D>)
    where
        Dim<D>: Scenic<D>,
    {
        let kinds = [
            grains.cloud.is_some(),
            grains.lattice.is_some(),
            grains.filled_box.is_some(),
            grains.file.is_some(),
        ];
        if kinds.iter().filter(|&&given| given).count() != 1 {
            self.refuse(key, "write exactly one of cloud, lattice, box and file");
        }
        if let Some(density) = grains.density {
            self.positive(&format!("{key}.density"), density, " kg/m³");
        } else if grains.file.is_none() {
            self.refuse(
                &format!("{key}.density"),
                "missing, and it has no default (kg/m³)",
            );
        }
        match (grains.radius, grains.file.is_some()) {
            (Some(radius), false) => self.radius(&format!("{key}.radius"), radius),
            (None, false) => {
                self.refuse(
                    &format!("{key}.radius"),
                    "missing, and it has no default (m)",
                );
            }
            (Some(_), true) => {
                self.refuse(
                    &format!("{key}.radius"),
                    "the radii come from the file; leave it out",
                );
            }
            (None, true) => {}
        }
        self.finite(&format!("{key}.velocity"), &grains.velocity.0);
        if let Some(cloud) = &grains.cloud {
            let key = format!("{key}.cloud");
            self.finite(&format!("{key}.centre"), &cloud.centre);
            self.positive(&format!("{key}.radius"), cloud.radius, " m");
            if D > 2 && cloud.arrangement == Arrangement::Sunflower {
                let key = format!("{key}.arrangement");
                self.refuse(
                    &key,
                    "a sunflower is of the plane: in space write \"random\"",
                );
            }
            self.amount::<D>(&key, cloud.solid_fraction, cloud.count);
        }
        if let Some(filled) = &grains.filled_box {
            let key = format!("{key}.box");
            self.corners(&key, &filled.lower, &filled.upper);
            self.amount::<D>(&key, filled.solid_fraction, filled.count);
        }
        if let Some(lattice) = &grains.lattice {
            let key = format!("{key}.lattice");
            self.corners(&key, &lattice.lower, &lattice.upper);
            match (lattice.spacing, lattice.solid_fraction) {
                (Some(spacing), None) => self.positive(&format!("{key}.spacing"), spacing, " m"),
                (None, Some(fraction)) => self.fraction::<D>(&key, fraction),
                _ => self.refuse(&key, "write exactly one of spacing and solid_fraction"),
            }
        }
    }

    fn radius(&mut self, key: &str, radius: Radius) {
        match radius {
            Radius::One(value) => self.positive(key, value, " m"),
            Radius::Range(range) => {
                self.positive(&format!("{key}.min"), range.min, " m");
                if !(range.max >= range.min && range.max.is_finite()) {
                    let min = range.min;
                    self.refuse(
                        &format!("{key}.max"),
                        format!("must be min = {min:e} m or more"),
                    );
                }
            }
        }
    }

    fn amount<const D: usize>(&mut self, key: &str, fraction: Option<f64>, count: Option<usize>)
    where
        Dim<D>: Scenic<D>,
    {
        match (fraction, count) {
            (Some(fraction), None) => self.fraction::<D>(key, fraction),
            (None, Some(count)) => self.at_least_one(&format!("{key}.count"), count),
            _ => self.refuse(key, "write exactly one of solid_fraction and count"),
        }
    }

    fn fraction<const D: usize>(&mut self, key: &str, fraction: f64)
    where
        Dim<D>: Scenic<D>,
    {
        let (densest, grains) = (Dim::<D>::DENSEST, Dim::<D>::GRAINS);
        if !(fraction > 0.0 && fraction < densest) {
            self.refuse(
                &format!("{key}.solid_fraction"),
                format!("must be greater than 0 and less than {densest}, the densest packing of equal {grains}"),
            );
        }
    }
}
