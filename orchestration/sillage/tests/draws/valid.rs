//! A scene that is valid: a box of fluid, grains or both, of any size, stiffness and density.

use toml::Value;

use super::random::Draw;

/// Coupling steps of a run.
const STEPS: f64 = 3.0;

/// Draw a scene.
pub fn scene(draw: &mut Draw) -> Value {
    let cell = draw.scale(1e-5, 1e-1);
    let cells = [2 + draw.below(6), 4 + draw.below(8)];
    let size = cells.map(|count| count as f64 * cell);
    let step = draw.scale(1e-3, 1.0) * (cell / 9.81).sqrt();
    let (fluid, grains) = draw.among(&[(true, true), (true, true), (true, false), (false, true)]);
    let sides = draw.among(&[Sides::Shut, Sides::Pipe, Sides::Through, Sides::Endless]);
    let mut text = format!(
        "run = {{ end_time = {:e}, coupling_step = {step:e} }}\ngravity.acceleration = [{}, {}]\n\
         output = {{ frames = {}, every = {step:e} }}\n",
        STEPS * step,
        draw.among(&["0.0", "1.0"]),
        draw.among(&["0.0", "-9.81"]),
        draw.once_in(8),
    );
    if fluid {
        text += &fluid_text(draw, cells, size, cell / step, sides);
    }
    if grains {
        text += &grains_text(draw, size, cell);
        text += &format!(
            "[contact]\nfriction = {}\ntolerance = {}\n",
            draw.among(&["0.0", "0.3", "10.0"]),
            draw.among(&["1e-2", "1e-5"])
        );
    }
    if grains && fluid {
        text += &coupling_text(draw, step, cell);
    }
    if grains && !fluid {
        text += &format!(
            "[particles.domain]\nlower = [0.0, 0.0]\nupper = [{:e}, {:e}]\nperiodic = [{}, false]\n",
            size[0],
            size[1],
            draw.once_in(2)
        );
    }
    toml::from_str(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// What is around the fluid.
#[derive(Clone, Copy)]
enum Sides {
    Shut,
    Pipe,
    Through,
    Endless,
}

/// A fluid; `speed` is a cell a step.
fn fluid_text(
    draw: &mut Draw,
    cells: [usize; 2],
    size: [f64; 2],
    speed: f64,
    sides: Sides,
) -> String {
    let (density, viscosity) = (draw.scale(1e-1, 1e4), draw.scale(1e-6, 1e2));
    let (inflow, profile) = (
        speed * draw.scale(1e-3, 1.0),
        draw.among(&["uniform", "parabolic"]),
    );
    let boundaries = match sides {
        Sides::Shut => match draw.once_in(2) {
            true => format!(
                "all = \"no-slip\"\ntop = {{ no-slip = {{ velocity = [{inflow:e}, 0.0] }} }}"
            ),
            false => "all = \"slip\"\nbottom = \"no-slip\"".to_string(),
        },
        Sides::Pipe => "left = \"periodic\"\nright = \"periodic\"\nall = \"no-slip\"".to_string(),
        Sides::Through => format!(
            "bottom = {{ inflow = {{ velocity = [0.0, {inflow:e}], profile = \"{profile}\" }} }}\n\
             top = {{ open = {{ pressure = 0.0 }} }}\nall = \"no-slip\""
        ),
        Sides::Endless => "all = \"periodic\"".to_string(),
    };
    let mean_flow = match sides {
        Sides::Endless => draw.among(&["mean_flow = \"zero\"\n", "mean_flow = \"free\"\n"]),
        _ => "",
    };
    let nonlinear = draw.among(&[
        "\"picard\"",
        "{ newton = { tolerance = 1e-6, iterations_max = 20 } }",
    ]);
    format!(
        "[fluid]\ndensity = {density:e}\ndynamic_viscosity = {viscosity:e}\n{mean_flow}\
         convection = {}\ntime_scheme = \"{}\"\nnonlinear = {nonlinear}\n\
         domain.rectangle = {{ lower = [0.0, 0.0], upper = [{:e}, {:e}], cells = [{}, {}], diagonals = \"{}\" }}\n\
         [fluid.boundaries]\n{boundaries}\n",
        draw.among(&["true", "false", "\"auto\""]),
        draw.among(&["backward-euler", "bdf2"]),
        size[0],
        size[1],
        cells[0],
        cells[1],
        draw.among(&["alternate", "uniform"]),
    )
}

/// One or two populations, one above the other.
fn grains_text(draw: &mut Draw, [width, height]: [f64; 2], cell: f64) -> String {
    let mut text = String::new();
    let halves = [[0.0, 0.5 * height], [0.5 * height, height]];
    for [low, high] in &halves[..1 + draw.below(2)] {
        let radius = (cell * draw.scale(0.05, 0.6)).min(0.1 * width.min(height));
        let (density, fixed) = (draw.scale(1e-1, 1e5), draw.once_in(6));
        let corners = format!("lower = [0.0, {low:e}], upper = [{width:e}, {high:e}]");
        let population = match draw.below(3) {
            0 => format!(
                "lattice = {{ {corners}, spacing = {:e}, pattern = \"{}\" }}",
                (radius * draw.scale(2.2, 6.0)).max(0.3 * cell),
                draw.among(&["square", "hexagonal"])
            ),
            1 => format!(
                "box = {{ {corners}, solid_fraction = {:e} }}",
                draw.scale(0.05, 0.3)
            ),
            _ => {
                let wide = 0.5 * width.min(high - low) - radius;
                let count = (0.2 * (wide / radius).powi(2)) as usize;
                format!(
                    "cloud = {{ centre = [{:e}, {:e}], radius = {wide:e}, count = {}, arrangement = \"sunflower\" }}",
                    0.5 * width,
                    0.5 * (low + high),
                    1 + draw.below(count.clamp(1, 50)),
                )
            }
        };
        text += &format!(
            "[[grains]]\ndensity = {density:e}\nradius = {radius:e}\nfixed = {fixed}\n{population}\n"
        );
    }
    text
}

fn coupling_text(draw: &mut Draw, step: f64, cell: f64) -> String {
    let scheme = draw.among(&[
        "\"staggered\"",
        "{ iterated = { tolerance = 1e-3, passes_max = 40 } }",
    ]);
    let law = draw.among(&[
        "stokes",
        "dallavalle",
        "wen-yu",
        "di-felice",
        "gidaspow",
        "beetstra",
        "migflow",
    ]);
    let mut text = format!(
        "[coupling]\nscheme = {scheme}\ndrag = \"{law}\"\nreaction = {}\n",
        !draw.once_in(5)
    );
    if draw.once_in(4) {
        text += &format!("geometry = {{ sphere = {{ depth = {:e} }} }}\n", 2.0 * cell);
    }
    if draw.once_in(5) {
        text += &format!(
            "adaptive = {{ step_min = {:e}, step_max = {step:e}, courant = 1.0 }}\n",
            0.2 * step
        );
    }
    text
}
