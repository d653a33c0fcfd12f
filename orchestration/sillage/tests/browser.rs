//! The report in a real browser. Needs Debian's `chromium` and `chromium-driver`; where they are
//! missing the test says so and does nothing:
//!
//! ```text
//! apt-get install chromium chromium-driver
//! SILLAGE_PICTURES=shots cargo test --release -p sillage --test commands browser -- --nocapture
//! ```

use std::io::{BufRead, BufReader};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::background::{Run, programs, small_cloud};
use crate::reports::tiny_run;

/// A browser that a test drives.
pub struct Browser {
    driver: Child,
    session: String,
}

impl Browser {
    /// None where there is no chromedriver.
    pub fn start() -> Option<Browser> {
        let mut driver = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let lines = BufReader::new(driver.stdout.take().expect("stdout")).lines();
        let port = lines
            .map_while(Result::ok)
            .find_map(|line| {
                let rest = line.split_once("successfully on port ")?.1;
                Some(rest.trim_end_matches('.').to_string())
            })
            .expect("a port");
        let mut arguments = vec![
            "--headless=new",
            "--disable-dev-shm-usage",
            "--enable-unsafe-swiftshader",
            "--use-angle=swiftshader",
        ];
        // The browser refuses its sandbox to root.
        let root = std::fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0);
        if root {
            arguments.push("--no-sandbox");
        }
        let options = json!({ "capabilities": { "alwaysMatch": { "goog:chromeOptions": { "args": arguments } } } });
        let base = format!("http://127.0.0.1:{port}/session");
        let answer = post(&base, options);
        let id = answer["value"]["sessionId"].as_str().expect("a session");
        Some(Browser {
            driver,
            session: format!("{base}/{id}"),
        })
    }

    /// A command of the driver.
    pub fn ask(&self, command: &str, body: Value) -> Value {
        post(&format!("{}/{command}", self.session), body)["value"].clone()
    }

    /// What a script returns.
    pub fn run(&self, script: &str) -> Value {
        self.ask("execute/sync", json!({ "script": script, "args": [] }))
    }

    /// A command of the browser's own protocol.
    pub fn tell(&self, command: &str, parameters: Value) {
        self.ask(
            "goog/cdp/execute",
            json!({ "cmd": command, "params": parameters }),
        );
    }

    /// Wait until a script says true.
    pub fn until(&self, script: &str) {
        let begun = Instant::now();
        while self.run(script) != true {
            assert!(
                begun.elapsed() < Duration::from_secs(30),
                "never true: {script}"
            );
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// A picture of the page; its bytes.
    pub fn picture(&self, path: &Path) -> usize {
        let shot = ureq::get(format!("{}/screenshot", self.session))
            .call()
            .expect("a picture")
            .body_mut()
            .with_config()
            .limit(50 << 20)
            .read_json::<Value>()
            .expect("JSON");
        let bytes = STANDARD
            .decode(shot["value"].as_str().expect("base64"))
            .expect("base64");
        std::fs::write(path, &bytes).expect("written");
        bytes.len()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = ureq::delete(&self.session).call();
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}

fn post(address: &str, body: Value) -> Value {
    ureq::post(address)
        .send_json(body)
        .unwrap_or_else(|error| panic!("{address}: {error}"))
        .body_mut()
        .read_json()
        .expect("JSON")
}

#[test]
fn the_report_plays_in_a_browser_without_a_network_in_light_and_dark_on_phone_and_desk() {
    let Some(browser) = Browser::start() else {
        eprintln!("SKIPPED: no chromedriver here; apt-get install chromium chromium-driver");
        return;
    };
    let kept = std::env::var_os("SILLAGE_PICTURES").map(PathBuf::from);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run");
    tiny_run(&path);
    let page = folder.path().join("page.html");
    let status = Command::new(programs().join("sillage"))
        .arg("report")
        .arg(&path)
        .arg("--out")
        .arg(&page)
        .status();
    assert!(status.expect("started").success());
    let pictures = kept.unwrap_or_else(|| folder.path().to_path_buf());
    std::fs::create_dir_all(&pictures).expect("a folder");
    println!("| scheme | width | state at first | after playing | bytes of the picture |");
    for scheme in ["light", "dark"] {
        for (width, height) in [(390, 844), (1280, 900)] {
            let media =
                json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
            browser.tell("Emulation.setEmulatedMedia", media);
            let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500 });
            browser.tell("Emulation.setDeviceMetricsOverride", metrics);
            browser.ask(
                "url",
                json!({ "url": format!("file://{}", page.display()) }),
            );
            browser.until("return document.documentElement.dataset.ready === 'yes'");
            let step =
                || browser.run("return Number(document.getElementById('canvas').dataset.step)");
            let first = step();
            browser.run("document.getElementById('play').click()");
            browser.until("return Number(document.getElementById('canvas').dataset.step) === 40");
            let counter = browser.run("return document.getElementById('counter').textContent");
            let size = browser.picture(&pictures.join(format!("report-{scheme}-{width}.png")));
            println!("| {scheme} | {width} | step {first} | {counter} | {size} |");
            assert_eq!(first, 0);
            assert!(
                counter
                    .as_str()
                    .is_some_and(|text| text.starts_with("step 40"))
            );
            assert!(size > 10_000, "an empty picture");
            let overflow = browser.run("return document.documentElement.scrollWidth - innerWidth");
            assert!(
                overflow.as_i64().is_some_and(|pixels| pixels <= 0),
                "{overflow} px too wide"
            );
            let outside = browser.run("return performance.getEntriesByType('resource').filter(e => e.name.startsWith('http')).length");
            assert_eq!(outside, 0, "the page asked the network");
            // Pixels of more than one colour: something was painted.
            let colours = browser.run(
                "const c = document.getElementById('canvas'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
                 const s = new Set(); for (let i = 0; i < d.length; i += 40) s.add(d[i] << 16 | d[i+1] << 8 | d[i+2]); return s.size",
            );
            assert!(
                colours.as_i64().is_some_and(|count| count > 20),
                "{colours} colours"
            );
        }
    }
    // Keys, fields and zoom.
    let canvas = "document.getElementById('canvas')";
    let press = |key: &str| {
        browser.run(&format!(
            "{canvas}.dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}' }}))"
        ))
    };
    press("Home");
    browser.until("return document.getElementById('canvas').dataset.step === '0'");
    press("ArrowRight");
    browser.until("return document.getElementById('canvas').dataset.step === '10'");
    for field in ["pressure", "porosity", "vorticity"] {
        browser.run(&format!(
            "document.querySelector('[value={field}]').click()"
        ));
        let name = browser.run("return document.getElementById('legend-name').textContent");
        println!("{field}: {name}");
        assert!(name.as_str().is_some_and(|name| name.starts_with(field)));
    }
    let before = browser.run("return document.getElementById('scale').textContent");
    for _ in 0..8 {
        press("+");
    }
    let after = browser.run("return document.getElementById('scale').textContent");
    println!("scale bar {before}, zoomed in {after}");
    assert_ne!(before, after);
}

/// A process that ends with its test, however that ends.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_view_of_a_running_run_follows_it_in_the_browser_until_its_end() {
    let Some(browser) = Browser::start() else {
        eprintln!("SKIPPED: no chromedriver here; apt-get install chromium chromium-driver");
        return;
    };
    let mut run = Run::start(&small_cloud(22.0));
    run.wait_for_steps(20);
    let view = Command::new(programs().join("sillage"))
        .arg("view")
        .arg(run.folder.path())
        .stdout(Stdio::piped())
        .spawn();
    let mut view = Ended(view.expect("started"));
    let mut line = String::new();
    BufReader::new(view.0.stdout.take().expect("stdout"))
        .read_line(&mut line)
        .expect("an address");
    let address = line.split_whitespace().next().expect("an address");
    browser.ask("url", json!({ "url": address }));
    browser.until("return document.documentElement.dataset.ready === 'yes'");
    let text = |id: &str| {
        browser.run(&format!(
            "return document.getElementById('{id}').textContent"
        ))
    };
    let (state, first) = (text("state"), text("counter"));
    println!("{state}: {first}; {}", text("summary"));
    assert_eq!(state, "running");
    // The page is loaded once: a mark on it stays while its numbers change.
    browser.run("document.body.dataset.mark = 'kept'");
    let count = "Number(document.getElementById('counter').textContent.split(' of ')[1])";
    let states = browser
        .run(&format!("return {count}"))
        .as_i64()
        .expect("a count");
    browser.until(&format!("return {count} > {states} + 3"));
    println!("{}; {}", text("counter"), text("summary"));
    let pid = nix::unistd::Pid::from_raw(run.child.id() as i32);
    nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGINT).expect("interrupted");
    assert_eq!(run.child.wait().expect("its end").code(), Some(130));
    browser.until("return document.getElementById('state').textContent.startsWith('exit 130')");
    println!("{}: {}", text("state"), text("summary"));
    assert_eq!(browser.run("return document.body.dataset.mark"), "kept");
}
