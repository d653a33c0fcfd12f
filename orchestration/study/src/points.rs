//! The points of a study: every combination of its axes, the first one running fastest.

use crate::keys::{AxisPoint, StudyFile};
use run::batch;

/// One point.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Names along the axes.
    pub names: Vec<String>,
    /// Size along the first axis.
    pub size: Option<f64>,
    /// Settings of the scene.
    pub settings: Vec<String>,
    /// A reference of its own.
    pub reference: Option<f64>,
}

/// All points.
pub fn points(study: &StudyFile) -> Vec<Point> {
    let count = study.axis.iter().map(|axis| axis.points.len()).product();
    (0..count)
        .map(|mut number: usize| {
            let chosen: Vec<&AxisPoint> = study
                .axis
                .iter()
                .map(|axis| {
                    let point = &axis.points[number % axis.points.len()];
                    number /= axis.points.len();
                    point
                })
                .collect();
            // What is set by the study comes first: points may change it.
            let mut settings: Vec<String> = match study.program {
                Some(_) => Vec::new(),
                None => vec!["output.frames=false".into()],
            };
            settings.extend(study.set.iter().cloned());
            settings.extend(chosen.iter().flat_map(|point| point.set.iter().cloned()));
            Point {
                names: chosen.iter().map(|point| point.name.clone()).collect(),
                size: chosen[0].size,
                settings,
                reference: chosen.iter().find_map(|point| point.reference),
            }
        })
        .collect()
}

/// The finer run of each series: the settings of the first axis replaced by these.
pub fn finer(study: &StudyFile, settings: &[String]) -> Vec<Point> {
    let mut coarse = study.clone();
    coarse.axis[0].points = vec![AxisPoint {
        name: "reference".into(),
        size: None,
        set: settings.to_vec(),
        reference: None,
    }];
    points(&coarse)
}

impl Point {
    /// Name of its folder.
    pub fn folder(&self) -> String {
        let parts = self.names.iter().map(|name| batch::folder_name(name));
        // What stands between two names stands in none.
        let parts: Vec<String> = parts.map(|part| part.replace('_', "%5f%")).collect();
        parts.join("_")
    }
}
