//! Arguments of the commands that make pages and tables.

use std::path::PathBuf;

use clap::Args;

use super::help::EXIT_CODES;

/// Arguments of `study`.
#[derive(Debug, Args)]
#[command(after_help = format!(
    "STUDY is a file or the name of a built-in study. It names a scene, axes to vary (keys as for --set),\n\
     a measure and a reference. Runs go one after another, interleaved over the repeats, each in\n\
     OUT/points/NAME/REPEAT; runs that are there are not run again, so Ctrl-C loses only the one in\n\
     progress. Written: study.json, study.csv, report.html, convergence and cost as .svg and .png.\n\
     Exit code 4 also when the run of a point failed: the table says which, and why.\n\n\
     Examples:\n  sillage study --list\n  sillage study one-grain\n  sillage study mine.toml --out runs/mine\n\n{EXIT_CODES}"
))]
pub struct StudyArgs {
    /// Study file (TOML), or the name of a built-in study
    #[arg(required_unless_present = "list")]
    pub study: Option<PathBuf>,
    /// Name the built-in studies
    #[arg(long, conflicts_with = "study")]
    pub list: bool,
    /// Folder of the study (default: runs/study-NAME)
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads each engine may use (default: 1, so that times can be compared)
    #[arg(long, value_name = "N", default_value = "1", value_parser = super::threads::parse)]
    pub threads: std::num::NonZeroUsize,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `stability`.
#[derive(Debug, Args)]
#[command(after_help = format!(
    "Every cell of a map is a small scene with a closed-form limit, run under four schemes: explicit,\n\
     semi-implicit with the solid's flux of the last step, staggered (one pass of the affine response),\n\
     and iterated, the default. A cell is stable, or: not finite, growth, not converged, budget broken,\n\
     wrong limit; or `check` refuses the scene and says why. The default must not fail: exit code 1.\n\n\
     Written: stability.json, stability.csv (passes, sub-steps and error of every cell), and for each pair\n\
     of axes heat/NAME.svg and .png. Each cell is a run folder OUT/cells/MAP/X_Y/SCHEME; those that are\n\
     there are not run again, so Ctrl-C loses only what is in progress. Remove OUT when the programs have\n\
     changed.\n\n\
     Examples:\n  sillage stability --list\n  sillage stability --quick\n  \
     sillage stability --axes stiffness-porosity --axes step-pair --out runs/stability\n\n{EXIT_CODES}"
))]
pub struct StabilityArgs {
    /// Only this pair of axes (repeatable); --list names them
    #[arg(long, value_name = "NAME")]
    pub axes: Vec<String>,
    /// Disks in the plane (2), or spheres in space (3)
    #[arg(long, value_name = "N", default_value = "2", value_parser = dimension)]
    pub dimension: stability::Dimension,
    /// A few points of every axis, the cheap ends among them: less than 3 minutes on two cores
    /// in the plane, less than 5 in space
    #[arg(long)]
    pub quick: bool,
    /// Name the pairs of axes, and what is run at their points
    #[arg(long)]
    pub list: bool,
    /// Where results and runs go (default: stability; in space stability-3d)
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Cells that run at the same time (default: all cores)
    #[arg(long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroUsize>,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// 2 or 3.
fn dimension(text: &str) -> Result<stability::Dimension, String> {
    let dimension = text.parse().ok().and_then(stability::Dimension::of);
    dimension.ok_or_else(|| "2, the plane, or 3, space".to_string())
}

impl StabilityArgs {
    /// Where results and runs go.
    pub fn out(&self) -> PathBuf {
        let usual = match self.dimension {
            stability::Dimension::Plane => "stability",
            stability::Dimension::Space => "stability-3d",
        };
        self.out.clone().unwrap_or_else(|| usual.into())
    }

    /// Cells that run at the same time.
    pub fn jobs(&self) -> usize {
        self.jobs
            .or_else(|| std::thread::available_parallelism().ok())
            .map_or(1, std::num::NonZeroUsize::get)
    }
}

/// Arguments of `view`.
#[derive(Debug, Args)]
#[command(after_help = format!(
    "Listens on 127.0.0.1 alone, serves this folder alone, until Ctrl-C.\n\
     Example: sillage run scenes/cloud.toml --out runs/cloud & sillage view runs/cloud\n\n{EXIT_CODES}"
))]
pub struct ViewArgs {
    /// Folder of a run or of a study
    pub folder: PathBuf,
    /// Port (default: a free one)
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// One JSON document with the address on stdout
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
#[command(after_help = format!(
    "The page plays the states written for ParaView (output.every of the scene) and draws steps.csv.\n\
     Example: sillage report runs/cloud && xdg-open runs/cloud/report.html\n\n{EXIT_CODES}"
))]
pub struct ReportArgs {
    /// Folder of a run or of a study
    pub folder: PathBuf,
    /// The file to write (default: report.html in the folder)
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// States in the animation at most, evenly taken
    #[arg(long, value_name = "N", default_value_t = 150, value_parser = clap::value_parser!(u32).range(1..))]
    pub states: u32,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
