//! The nodal fields that describe the solid.

use std::sync::Arc;

use space::{Vector, flat};

use crate::error::{FluidError, place};
use crate::mesh::simplices::Mesh;

/// Nodal fields of the solid's affine response; `None` is the default: porosity 1, all else 0.
#[derive(Debug, Clone, Copy, Default)]
pub struct SolidFields<'a> {
    /// φ
    pub porosity: Option<&'a [f64]>,
    /// β \[kg/(m³ s)\]
    pub drag: Option<&'a [f64]>,
    /// s \[N/m³\], interleaved: D numbers a node
    pub drag_source: Option<&'a [f64]>,
    /// c
    pub entrained_fraction: Option<&'a [f64]>,
    /// j⁰ \[m/s\], interleaved
    pub solid_flux: Option<&'a [f64]>,
    /// κ \[m³ s/kg\]
    pub solid_mobility: Option<&'a [f64]>,
    /// β of fixed grains \[kg/(m³ s)\]
    pub fixed_drag: Option<&'a [f64]>,
}

/// The same fields, complete, checked and owned.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid<const D: usize> {
    /// What enters the matrix.
    pub matrix: Arc<SolidMatrix>,
    /// s \[N/m³\].
    pub drag_source: Vec<Vector<D>>,
    /// j⁰ \[m/s\].
    pub solid_flux: Vec<Vector<D>>,
}

/// The fields of the solid that enter the matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidMatrix {
    /// φ
    pub porosity: Vec<f64>,
    /// β \[kg/(m³ s)\]
    pub drag: Vec<f64>,
    /// c
    pub entrained_fraction: Vec<f64>,
    /// κ \[m³ s/kg\]
    pub solid_mobility: Vec<f64>,
    /// β of fixed grains \[kg/(m³ s)\]; empty: none is fixed
    pub fixed_drag: Vec<f64>,
}

impl<const D: usize> Solid<D> {
    /// Fill in defaults; refuse wrong shapes, values that are not finite and φ ≤ 0.
    pub fn new<const N: usize>(
        fields: &SolidFields<'_>,
        mesh: &Mesh<D, N>,
    ) -> Result<Solid<D>, FluidError> {
        let n = mesh.node_count();
        let scalar = |field, values: Option<&[f64]>, default: f64| match values {
            None => Ok(vec![default; n]),
            Some(values) => checked(field, values, 1, mesh).map(<[f64]>::to_vec),
        };
        let vector = |field, values: Option<&[f64]>| match values {
            None => Ok(vec![Vector::zeros(); n]),
            Some(values) => checked(field, values, D, mesh)
                .map(|values| flat::vectors(values).unwrap_or_default().to_vec()),
        };
        let porosity = scalar("porosity", fields.porosity, 1.0)?;
        if let Some(node) = porosity.iter().position(|&value| value <= 0.0) {
            return Err(FluidError::Porosity {
                node,
                place: place(&mesh.position[node]),
                value: porosity[node],
            });
        }
        let fixed_drag = match fields.fixed_drag {
            None => Vec::new(),
            given => scalar("fixed_drag", given, 0.0)?,
        };
        Ok(Solid {
            matrix: Arc::new(SolidMatrix {
                porosity,
                drag: scalar("drag", fields.drag, 0.0)?,
                entrained_fraction: scalar("entrained_fraction", fields.entrained_fraction, 0.0)?,
                solid_mobility: scalar("solid_mobility", fields.solid_mobility, 0.0)?,
                fixed_drag,
            }),
            drag_source: vector("drag_source", fields.drag_source)?,
            solid_flux: vector("solid_flux", fields.solid_flux)?,
        })
    }
}

/// The values, if there are `components` for each node and all are finite.
fn checked<'a, const D: usize, const N: usize>(
    field: &'static str,
    values: &'a [f64],
    components: usize,
    mesh: &Mesh<D, N>,
) -> Result<&'a [f64], FluidError> {
    let expected = components * mesh.node_count();
    if values.len() != expected {
        return Err(FluidError::Shape {
            field,
            got: values.len(),
            expected,
        });
    }
    finite(field, values, components, mesh)?;
    Ok(values)
}

/// An error that names the first value that is not finite.
pub(crate) fn finite<const D: usize, const N: usize>(
    what: &'static str,
    values: &[f64],
    components: usize,
    mesh: &Mesh<D, N>,
) -> Result<(), FluidError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let node = at / components;
            Err(FluidError::NotFinite {
                what,
                node,
                place: place(&mesh.position[node]),
                value: values[at],
            })
        }
    }
}
