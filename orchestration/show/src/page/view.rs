//! `sillage view`: the page of a run served on this machine, renewed while the run goes on.
//!
//! | path | answer |
//! | --- | --- |
//! | `/` | the page; of a study, the one it wrote |
//! | `/api/run` | run.json, the steps, the stage, and what states there are |
//! | `/api/state/N` | one state |
//!
//! Nothing else is served, no path of a request is ever opened, and requests that name another
//! host are refused, so that no page elsewhere can read a run through the browser.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::time::Duration;

use run::interrupt::Interrupts;
use scene::Error;
use serde_json::{Value, json};
use tiny_http::{Header, Method, Request, Response, Server};

use super::document::{STUDY_FILE, head};
use super::html::page;
use super::states::{Frame, Reader};

/// How often an interruption is looked for.
const TICK: Duration = Duration::from_millis(200);

/// Serves one folder.
pub struct View {
    folder: PathBuf,
    server: Server,
    reader: Option<Reader>,
    frames: Vec<Frame>,
}

type Answer = Response<Cursor<Vec<u8>>>;

impl View {
    /// Listen on this machine alone; port 0 takes a free one.
    pub fn open(folder: &Path, port: u16) -> Result<View, Error> {
        let is_study = folder.join(STUDY_FILE).is_file();
        if !is_study {
            head(folder)?;
        }
        let server = Server::http(("127.0.0.1", port)).map_err(|error| {
            Error::Usage(format!(
                "--port {port}: cannot listen on 127.0.0.1:{port}: {error}"
            ))
        })?;
        Ok(View {
            folder: folder.to_path_buf(),
            server,
            reader: None,
            frames: Vec::new(),
        })
    }

    /// Where it listens.
    pub fn address(&self) -> String {
        let address = self.server.server_addr();
        format!(
            "http://{}/",
            address
                .to_ip()
                .map_or_else(String::new, |ip| ip.to_string())
        )
    }

    /// Answer until interrupted.
    pub fn serve(&mut self, interrupts: &Interrupts) -> Result<(), Error> {
        while interrupts.so_far() == 0 {
            let received = self
                .server
                .recv_timeout(TICK)
                .map_err(Error::file("cannot listen as", self.address()))?;
            if let Some(request) = received {
                let answer = self.answer(&request);
                // Whoever asked may be gone.
                let _ = request.respond(answer);
            }
        }
        Ok(())
    }

    fn answer(&mut self, request: &Request) -> Answer {
        if !matches!(request.method(), Method::Get | Method::Head) {
            return plain(405, "only GET is answered");
        }
        if !self.is_meant(request) {
            return plain(403, "this server answers to its own address alone");
        }
        let path = request
            .url()
            .split('?')
            .next()
            .unwrap_or_default()
            .to_string();
        let outcome = match path.as_str() {
            "/" => self.front(),
            "/api/run" => self
                .run()
                .map(|document| answer("application/json", document.to_string())),
            other => match other.strip_prefix("/api/state/").map(str::parse::<usize>) {
                Some(Ok(number)) => self.state(number),
                _ => return plain(404, "nothing is here"),
            },
        };
        outcome.unwrap_or_else(|error| plain(500, &error.to_string()))
    }

    /// A page elsewhere whose name was made to lead here sends that name.
    fn is_meant(&self, request: &Request) -> bool {
        let port = self.server.server_addr().to_ip().map_or(0, |ip| ip.port());
        let host = request
            .headers()
            .iter()
            .find(|header| header.field.equiv("Host"));
        host.is_some_and(|host| {
            let host = host.value.as_str();
            ["127.0.0.1", "localhost"]
                .iter()
                .any(|name| host == format!("{name}:{port}"))
        })
    }

    fn front(&mut self) -> Result<Answer, Error> {
        if self.folder.join(STUDY_FILE).is_file() {
            let file = self.folder.join("report.html");
            let text = std::fs::read_to_string(&file).map_err(Error::file("cannot read", &file))?;
            return Ok(answer("text/html; charset=utf-8", text));
        }
        let title = self
            .folder
            .file_name()
            .map_or("run".into(), |name| name.to_string_lossy());
        Ok(answer(
            "text/html; charset=utf-8",
            page(
                &title,
                &json!({ "live": true, "dimension": head(&self.folder)?["dimension"] }),
            ),
        ))
    }

    fn run(&mut self) -> Result<Value, Error> {
        let mut document = head(&self.folder)?;
        self.renew(&document)?;
        document["live"] = json!(true);
        document["stage"] = self
            .reader
            .as_ref()
            .map_or(Value::Null, |reader| reader.stage.clone());
        let brief = |frame: &Frame| {
            json!({
                "time": frame.time,
                "usual": frame.usual,
                "speed_high": frame.grain_speed.as_ref().map(|speed| speed.high),
            })
        };
        document["frames"] = self.frames.iter().map(brief).collect();
        Ok(document)
    }

    /// Take over states that were written since.
    fn renew(&mut self, document: &Value) -> Result<(), Error> {
        let scene = &document["run"]["scene"]["resolved"];
        let fresh = || Reader::open(&self.folder, scene);
        let mut reader = self.reader.take().unwrap_or_else(fresh);
        let entries = reader.entries()?;
        let same = self
            .frames
            .iter()
            .zip(&entries)
            .all(|(frame, entry)| frame.time == entry.time);
        if entries.len() < self.frames.len() || !same {
            // Another run in the same folder.
            reader = Reader::open(&self.folder, scene);
            self.frames.clear();
        }
        for entry in &entries[self.frames.len()..] {
            self.frames
                .push(reader.frame(entry, &scene["particles"]["walls"])?);
        }
        self.reader = Some(reader);
        Ok(())
    }

    fn state(&mut self, number: usize) -> Result<Answer, Error> {
        if number >= self.frames.len() {
            self.run()?;
        }
        Ok(match self.frames.get(number) {
            Some(frame) => answer("application/json", json!(frame).to_string()),
            None => plain(404, &format!("there are {} states", self.frames.len())),
        })
    }
}

fn plain(code: u16, text: &str) -> Answer {
    answer("text/plain; charset=utf-8", text.to_string()).with_status_code(code)
}

fn answer(kind: &str, text: String) -> Answer {
    let mut answer = Response::from_string(text);
    for (name, value) in [
        ("Content-Type", kind),
        ("Cache-Control", "no-store"),
        ("X-Content-Type-Options", "nosniff"),
    ] {
        // Constants of this file: always headers.
        if let Ok(header) = Header::from_bytes(name, value) {
            answer = answer.with_header(header);
        }
    }
    answer
}
