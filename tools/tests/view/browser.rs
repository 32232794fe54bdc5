//! A real browser, spoken to over pipes by its DevTools protocol.

use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::house::PATIENCE;

/// Where the browser is, or that it must be there: a path, or `required`.
const WHICH: &str = "PSCHEMA_BROWSER";

/// How long it may be silent before it is taken to be closed.
const CLOSES_WITHIN: Duration = Duration::from_secs(10);

/// A browser with one page.
pub(crate) struct Browser {
    process: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    asked: u64,
    session: String,
    /// What the page complained about.
    pub(crate) errors: Vec<String>,
    _profile: TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Closed by itself it ends its children first, and nobody writes into the profile that is removed next.
        drop(self.to.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0"));
        while self.from.recv_timeout(CLOSES_WITHIN).is_ok() {}
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

/// The browser of this machine; none when there is none and nobody insists.
fn found() -> Option<PathBuf> {
    let asked = std::env::var(WHICH).ok().filter(|asked| !asked.is_empty());
    match asked.as_deref() {
        None | Some("required") => (),
        Some(path) => {
            let path = PathBuf::from(path);
            assert!(path.is_file(), "{WHICH} says {}, which is not there", path.display());
            return Some(path);
        }
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = std::env::split_paths(&folders)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|path| path.is_file());
    assert!(found.is_some() || asked.is_none(), "{WHICH}=required, and there is no chromium in PATH");
    if found.is_none() {
        println!(
            "skipped: no chromium in PATH. Install one, or give its path in {WHICH}, to test the page in it"
        );
    }
    found
}

impl Browser {
    /// A browser; none where there is none.
    pub(crate) fn launch() -> Option<Self> {
        let path = found()?;
        let profile = tempfile::Builder::new().prefix("psv-chromium-").tempdir_in("/tmp").unwrap();
        // It reads what it is asked from descriptor 3 and answers on 4.
        let mut command = Command::new("sh");
        command.args(["-c", "exec \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1", "sh"]).arg(path);
        command.args(["--headless", "--remote-debugging-pipe", "--no-first-run", "--disable-gpu"]);
        command.args(["--disable-dev-shm-usage", "--disable-extensions", "--disable-background-networking"]);
        command.args(["--hide-scrollbars", "--mute-audio"]);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        if rustix::process::getuid().is_root() {
            command.arg("--no-sandbox");
        }
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let to = process.stdin.take().unwrap();
        let mut answers = BufReader::new(process.stdout.take().unwrap());
        let (sender, from) = channel();
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            while answers.read_until(0, &mut bytes).is_ok_and(|count| count > 0) {
                let message = serde_json::from_slice(bytes.strip_suffix(&[0]).unwrap_or(&bytes));
                bytes.clear();
                if message.is_ok_and(|message: Value| sender.send(message).is_err()) {
                    return;
                }
            }
        });
        let mut browser = Self {
            process,
            to,
            from,
            asked: 0,
            session: String::new(),
            errors: Vec::new(),
            _profile: profile,
        };
        let target = browser.ask("Target.createTarget", &json!({"url": "about:blank"}));
        let attached = json!({"targetId": target["targetId"], "flatten": true});
        browser.session =
            browser.ask("Target.attachToTarget", &attached)["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Runtime.enable", "Log.enable", "Page.enable"] {
            browser.ask(domain, &json!({}));
        }
        Some(browser)
    }

    /// Asks the browser, and waits for its answer.
    fn ask(&mut self, method: &str, parameters: &Value) -> Value {
        self.asked += 1;
        let mut message = json!({"id": self.asked, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = Value::String(self.session.clone());
        }
        let mut bytes = serde_json::to_vec(&message).unwrap();
        bytes.push(0);
        self.to.write_all(&bytes).unwrap();
        self.to.flush().unwrap();
        let begun = Instant::now();
        loop {
            let left = PATIENCE.saturating_sub(begun.elapsed());
            let message = self.from.recv_timeout(left).unwrap_or_else(|error| panic!("{method}: {error}"));
            if message["id"] == self.asked {
                assert!(message["error"].is_null(), "{method}: {}", message["error"]);
                return message["result"].clone();
            }
            self.heard(&message);
        }
    }

    /// Keeps what the page complains about.
    fn heard(&mut self, event: &Value) {
        let parameters = &event["params"];
        let complaint = match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Runtime.consoleAPICalled") => parameters["type"] == "error",
            Some("Log.entryAdded") => parameters["entry"]["level"] == "error",
            _ => false,
        };
        if complaint {
            self.errors.push(parameters.to_string());
        }
    }

    /// Goes to an address.
    pub(crate) fn go(&mut self, url: &str) {
        self.ask("Page.navigate", &json!({"url": url}));
    }

    /// What an expression comes to in the page.
    pub(crate) fn eval(&mut self, expression: &str) -> Value {
        let parameters = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let result = self.ask("Runtime.evaluate", &parameters);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {}", result["exceptionDetails"]);
        result["result"]["value"].clone()
    }

    /// Waits until an expression holds in the page, and gives what it comes to.
    pub(crate) fn until(&mut self, expression: &str) -> Value {
        let begun = Instant::now();
        loop {
            // In the page itself, once in each of its frames, so that a new page does not end the wait.
            let value = self.eval(&format!(
                "new Promise((done) => {{ const value = (() => {{ try {{ return {expression} }} catch {{ return false }} }})(); \
                 value ? done(value) : setTimeout(() => done(false), 20) }})"
            ));
            if value != Value::Bool(false) {
                return value;
            }
            assert!(begun.elapsed() < PATIENCE, "waited for {expression}; complaints: {:?}", self.errors);
        }
    }

    /// A window of another size, light or dark.
    pub(crate) fn look(&mut self, width: u32, height: u32, dark: bool) {
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        self.ask("Emulation.setDeviceMetricsOverride", &size);
        let scheme = json!([{"name": "prefers-color-scheme", "value": if dark { "dark" } else { "light" }}]);
        self.ask("Emulation.setEmulatedMedia", &json!({"features": scheme}));
    }

    /// The page as PNG; all of it, or what the window shows.
    pub(crate) fn picture(&mut self, whole: bool) -> Vec<u8> {
        let shot =
            self.ask("Page.captureScreenshot", &json!({"format": "png", "captureBeyondViewport": whole}));
        from_base64(shot["data"].as_str().unwrap())
    }
}

fn from_base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = text.bytes().filter_map(|byte| DIGITS.iter().position(|digit| *digit == byte));
    let (mut bytes, mut kept, mut bits) = (Vec::new(), 0_usize, 0);
    for digit in digits {
        kept = (kept << 6 | digit) & 0xffff;
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push(u8::try_from(kept >> bits & 0xff).unwrap());
        }
    }
    bytes
}
