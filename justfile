# Everything that must hold before a change is taken; what CI runs.
check:
    ./.ci/run

# The fast tests of the whole workspace.
test:
    cargo test --release --workspace

# The slow ones too: convergence, long runs, stress.
test-all:
    cargo test --release --workspace -- --include-ignored

# All of docs/reliability.md but the soak: processes killed, stopped and in each other's way, runs resumed, inputs,
# load (under an hour on two cores).
faults:
    cargo test --release --workspace --test commands -- --include-ignored --test-threads 1 --skip soak \
        instants kills stops strays namespaces full_disk folders resume load
    cargo test --release --workspace --test suite -- private processes runspaces faults codec limits
    cargo test --release --workspace --test engines -- conform
    cargo test --release --workspace --test inputs

# Two hours of a fluidised bed: what its processes hold.
soak:
    cargo test --release --workspace --test commands -- --ignored soak --nocapture

# Format all code.
fmt:
    cargo fmt --all

# Run a scene, e.g. `just run cloud --out runs/cloud`.
run scene *arguments:
    ./sillage run scenes/{{scene}}.toml {{arguments}}

# The pages of the code, in the browser.
doc:
    cargo doc --release --workspace --no-deps --open

# The Python package and engines: set up once with engines/set-up.
test-python:
    engines/.venv/bin/python -m pytest engines/kit/python/tests
    engines/.venv/bin/python -m pytest engines/tests

# Renew the tables and plots of all studies, and the pictures of the README that come from them (two
# hours; runs that are there are kept).
studies:
    for study in studies/*.toml; do ./sillage study "$study" || echo "$study: not every point ran"; done
    just study-pictures

# The tables of docs/performance.md that need no other program.
bench:
    cargo bench -p fluid-solver --bench fluid -- 80x240
    cargo bench -p coupler --bench transfer
    cargo test --release --workspace --test fluid plane_systems -- --ignored --nocapture
    cargo test --release --workspace --test suite a_contact_of_balls a_small_step_of_balls memory_of_a_ball -- --ignored --nocapture

# The pictures of the README, from the studies that were run.
study-pictures:
    cp runs/study-cloud-velocity/convergence.png docs/pictures/study-cloud-velocity.png
    cp runs/study-cloud-ga10-time/convergence.png docs/pictures/study-cloud-ga10-time.png
    cp runs/study-contact/cost.png docs/pictures/study-contact.png
    cp runs/study-exchange/convergence.png docs/pictures/study-exchange.png

# The first picture of the README.
cloud-picture:
    ./sillage run scenes/cloud.toml --out runs/cloud
    cp runs/cloud/overview.png docs/pictures/cloud.png
