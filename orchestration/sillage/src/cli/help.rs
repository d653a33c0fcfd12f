//! What `--help` says beyond the arguments.

/// What the command's exit code means.
pub const EXIT_CODES: &str = "\
Exit codes:
  0 ok                     5 partner lost
  1 outside the tolerance (replay, diff), or a check failed (conform, stability)
  2 usage, scene or file   6 time limit
  3 handshake or version   7 not finite, or an invariant broken
  4 engine failed          8 not converged
  130 interrupted";

/// Examples of the whole program.
pub const EXAMPLES: &str = "\
Examples:
  sillage run scenes/cloud.toml
  sillage run scenes/cloud.toml --out runs/coarse --set fluid.refinement.near_grains=1.236e-3
  sillage resume runs/coarse
  sillage check scenes/cloud.toml
  sillage plan scenes/cloud.toml --out by-hand
  sillage run scenes/cloud.toml --record --out runs/cloud
  sillage replay runs/cloud/exchange.mcap --as fluid
  sillage diff runs/cloud runs/coarse
  sillage report runs/cloud
  sillage study one-grain
  sillage stability --quick
  sillage doctor --clean";

/// Examples and exit codes of `conform`.
pub const CONFORM_HELP: &str = "\
Examples:
  sillage conform --as fluid -- target/release/sillage-fluid
  sillage conform --as particles --json -- python3 my_engine.py --option 1
  sillage conform --as particles --check same-request --check nan -- ./my-engine

Exit codes:
  0 nothing failed         2 usage or scene
  1 a check failed         4 the command cannot be started";
