//! The page as anybody on this machine may try it: with and without the token, with what is no HTTP.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, Ipv6Addr, TcpStream};

use serde_json::Value;

use crate::forged::unlike;
use crate::house::{Address, House, PATIENCE};

/// What a server sent until it closed.
fn exchange(port: u16, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    // It may have had enough before everything is sent.
    drop(stream.write_all(bytes));
    let mut answer = Vec::new();
    drop(stream.read_to_end(&mut answer));
    String::from_utf8_lossy(&answer).into_owned()
}

fn status(answer: &str) -> Option<u16> {
    answer.strip_prefix("HTTP/1.1 ")?.get(..3)?.parse().ok()
}

fn request(at: &Address, method: &str, path: &str, host: &str, headers: &str, body: &str) -> String {
    let length = body.len();
    let text = format!(
        "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: {length}\r\n{headers}\r\n{body}"
    );
    exchange(at.port, text.as_bytes())
}

fn get(at: &Address, path: &str) -> String {
    request(at, "GET", &format!("/{}/{path}", at.token), &format!("127.0.0.1:{}", at.port), "", "")
}

fn ask(at: &Address, question: &str) -> (Option<u16>, Value) {
    let host = format!("127.0.0.1:{}", at.port);
    let json = "Content-Type: application/json\r\n";
    let answer = request(at, "POST", &format!("/{}/ask", at.token), &host, json, question);
    let body = answer.split_once("\r\n\r\n").map_or("", |(_, body)| body);
    (status(&answer), serde_json::from_str(body).unwrap_or(Value::Null))
}

#[test]
fn the_page_is_whole_and_says_what_it_may_load() {
    let house = House::new();
    let (_view, at) = house.view(&[]);
    let page = get(&at, "");
    assert_eq!(status(&page), Some(200), "{page}");
    let head = page.split_once("\r\n\r\n").unwrap().0.to_lowercase();
    for header in [
        "content-security-policy: default-src 'none'; script-src 'self';",
        "referrer-policy: no-referrer",
        "x-content-type-options: nosniff",
        "cache-control: no-store",
        "content-type: text/html; charset=utf-8",
    ] {
        assert!(head.contains(header), "no {header} in {head}");
    }
    assert!(!head.contains("access-control-"), "nobody else may read it: {head}");
    let linked = page.split('"').filter_map(|text| text.strip_prefix("./"));
    for file in linked {
        assert_eq!(status(&get(&at, file)), Some(200), "{file}");
    }
}

#[test]
fn only_the_whole_address_of_this_machine_lets_in() {
    let house = House::new();
    let (_view, at) = house.view(&[]);
    let (here, token) = (format!("127.0.0.1:{}", at.port), &at.token);
    let other = token.chars().rev().collect::<String>();
    let upper = token.to_uppercase();
    let got = |path: &str, host: &str, headers: &str| status(&request(&at, "GET", path, host, headers, ""));
    assert_eq!(got(&format!("/{token}/"), &here, ""), Some(200));
    for path in ["/", "/main.js", &format!("/{other}/"), &format!("/{upper}x/"), &format!("/{token}")] {
        assert_eq!(got(path, &here, ""), Some(403), "{path}");
    }
    // `localhost` is `::1` first for many programs.
    for name in ["localhost", "[::1]"] {
        assert_eq!(got(&format!("/{token}/"), &format!("{name}:{}", at.port), ""), Some(200), "{name}");
    }
    // Where the machine has IPv6 at all, nobody else has that port of it.
    if std::net::TcpListener::bind((Ipv6Addr::LOCALHOST, 0)).is_ok() {
        TcpStream::connect((Ipv6Addr::LOCALHOST, at.port)).unwrap();
    }
    for host in ["evil.example", "127.0.0.1", "127.0.0.1:1", ""] {
        assert_eq!(got(&format!("/{token}/"), host, ""), Some(403), "{host}");
    }
    let foreign = "Origin: http://evil.example\r\n";
    assert_eq!(got(&format!("/{token}/"), &here, foreign), Some(403));
    let ask = |headers: &str| {
        status(&request(
            &at,
            "POST",
            &format!("/{token}/ask"),
            &here,
            headers,
            r#"{"question":{"ask":"about"}}"#,
        ))
    };
    assert_eq!(ask("Content-Type: application/json\r\nSec-Fetch-Site: cross-site\r\n"), Some(403));
    assert_eq!(ask("Content-Type: text/plain\r\n"), Some(415));
    for method in ["PUT", "DELETE", "OPTIONS", "TRACE", "HEAD"] {
        assert_eq!(
            status(&request(&at, method, &format!("/{token}/ask"), &here, "", "")),
            Some(405),
            "{method}"
        );
    }
}

#[test]
fn nobody_outside_this_machine_is_listened_to() {
    let house = House::new();
    let (_view, at) = house.view(&[]);
    // Every address of 127/8 is this machine, but only one is listened on.
    assert!(TcpStream::connect((Ipv4Addr::new(127, 0, 0, 2), at.port)).is_err());
}

#[test]
fn without_a_daemon_it_says_so_and_stays() {
    let house = House::new();
    let (_view, at) = house.view(&[]);
    for question in [r#"{"question":{"ask":"about"}}"#, r#"{"question":{"ask":"live","trace_from":0}}"#] {
        let (status, answer) = ask(&at, question);
        assert_eq!((status, &answer["no_daemon"]), (Some(503), &Value::Bool(true)), "{answer}");
        assert!(answer["problem"].as_str().unwrap().contains("no daemon"), "{answer}");
    }
    let (status, answer) = ask(&at, r#"{"question":{"ask":"report"},"until":3}"#);
    assert_eq!(status, Some(409), "{answer}");
    assert!(answer["problem"].as_str().unwrap().contains("--data"), "{answer}");
}

#[test]
fn what_is_no_question_is_refused_and_harms_nobody() {
    let house = House::new();
    let (_view, at) = house.view(&[]);
    for (question, expected) in [
        ("", 400),
        ("[]", 400),
        ("{\"question\":{\"ask\":\"shutdown\"}}", 400),
        ("{\"question\":{\"ask\":\"show\",\"id\":1e99}}", 400),
        (&format!("{}{}", "[".repeat(3000), "]".repeat(1000)), 400),
        (&format!("{{\"question\":\"{}\"}}", "x".repeat(5000)), 413),
    ] {
        let (status, answer) = ask(&at, question);
        assert_eq!(status, Some(expected), "{}: {answer}", &question[..question.len().min(60)]);
    }
    assert_eq!(status(&get(&at, "picture?after=1")), Some(204), "there is no body");
    assert_eq!(status(&get(&at, "fields")), Some(204));
}

#[test]
fn hostile_bytes_end_their_own_connection_only() {
    let house = House::new();
    let (_view, at) = house.view(&[]);
    let many_headers = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(1000));
    let long_header = format!("GET / HTTP/1.1\r\nHost: {}\r\n\r\n", "h".repeat(200_000));
    let smuggled = format!(
        "POST /{0}/ask HTTP/1.1\r\nHost: 127.0.0.1:{1}\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET /",
        at.token, at.port
    );
    let attempts: [&[u8]; 7] = [
        b"\0\0\0\0\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03 not tls\r\n\r\n",
        b"GET\r\n\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        many_headers.as_bytes(),
        long_header.as_bytes(),
        smuggled.as_bytes(),
    ];
    for bytes in attempts {
        let answer = exchange(at.port, bytes);
        let refused = status(&answer).is_none_or(|status| (400..500).contains(&status));
        assert!(refused, "{:?}: {answer}", String::from_utf8_lossy(&bytes[..bytes.len().min(40)]));
    }
    assert_eq!(status(&get(&at, "")), Some(200), "others are served as before");
}

#[test]
fn idle_connections_do_not_keep_others_out() {
    let house = House::new();
    let (_view, at) = house.view(&[]);
    // More than are served at a time, saying nothing; they are closed in their time, and the others get in.
    let idle: Vec<_> = (0..40).map(|_| TcpStream::connect((Ipv4Addr::LOCALHOST, at.port)).unwrap()).collect();
    assert_eq!(status(&get(&at, "")), Some(200));
    drop(idle);
}

#[test]
fn memory_on_disk_is_looked_into_without_a_daemon_and_takes_no_orders() {
    let house = House::new();
    let life = house.life(120);
    let data = life.to_str().unwrap();
    let (view, at) = house.view(&["--data", data]);
    let (_, about) = ask(&at, r#"{"question":{"ask":"about"}}"#);
    let last = about["last_step"].as_u64().unwrap();
    assert!(last >= 120 && about["live"] == false && about["oldest_step"] == 0, "{about}");
    for until in [last, 60, 60, 20] {
        let question = format!(r#"{{"question":{{"ask":"live","trace_from":0}},"until":{until}}}"#);
        let (status, live) = ask(&at, &question);
        assert_eq!((status, live["step"].as_u64()), (Some(200), Some(until)), "{live}");
        let told = house.json(&["status", "--data", data, "--until", &until.to_string()]).unwrap();
        assert_eq!(live["schemas_total"], told["schemas_total"], "after step {until}");
        let explained = house.json(&["explain", "--data", data, "--until", &until.to_string()]).unwrap();
        assert_eq!(live["explanation"]["action"], explained["action"], "after step {until}");
        let terms = live["explanation"]["candidates"][0]["terms"].as_array().unwrap();
        let sum: f64 = terms.iter().map(|term| term["value"].as_f64().unwrap()).sum();
        let first = &live["explanation"]["candidates"][0];
        let product = first["excitation"].as_f64().unwrap() * first["distance"].as_f64().unwrap();
        assert!((sum - product).abs() < 1e-9, "the terms add up: {first}");
    }
    let beyond = format!(r#"{{"question":{{"ask":"report"}},"until":{}}}"#, last + 1);
    let (status, answer) = ask(&at, &beyond);
    assert_eq!(status, Some(422), "{answer}");
    for order in ["hold", "resume", "step"] {
        let (status, answer) = ask(&at, &format!(r#"{{"question":{{"ask":"{order}"}}}}"#));
        assert_eq!(status, Some(409), "{order}: {answer}");
    }
    let (_, answer) = ask(&at, r#"{"question":{"ask":"graph","depth":1},"until":60}"#);
    assert!(
        answer["svg"].as_str().unwrap().contains("<svg") && answer["nodes_total"].as_u64() > Some(0),
        "{answer}"
    );
    let list =
        r#"{"question":{"ask":"schemas","generalised":false,"sort":"age","limit":5,"offset":3},"until":60}"#;
    let (_, answer) = ask(&at, list);
    assert_eq!(answer["schemas"][0]["id"], 3, "{answer}");
    view.end();
}

fn of(question: &str, until: u64) -> String {
    format!(r#"{{"question":{question},"until":{until}}}"#)
}

const LIVE: &str = r#"{"ask":"live","trace_from":0}"#;

#[test]
fn after_a_step_that_decided_nothing_the_decision_before_it_is_weighed() {
    let house = House::new();
    let (life, last) = house.finished();
    let data = life.to_str().unwrap();
    let (_view, at) = house.view(&["--data", data]);
    let (_, live) = ask(&at, &of(LIVE, last));
    let decided = live["explanation"]["step"].as_u64().unwrap();
    assert!(decided < last, "step {last} decided nothing: {live}");
    assert_eq!((&live["step"], &live["undecided"]), (&Value::from(last), &Value::Null), "{live}");
    let (status, answer) = ask(&at, &of(r#"{"ask":"why-not","id":3}"#, last));
    assert_eq!(status, Some(200), "{answer}");
    let text = answer["text"].as_str().unwrap();
    assert!(text.contains(&decided.to_string()), "of step {decided}: {text}");
    // Memory is still that of the moment, not of the decision.
    let (_, again) = ask(&at, &of(LIVE, last));
    assert_eq!(again["step"], last, "{again}");
}

#[test]
fn a_decision_that_can_not_be_made_again_hides_nothing_else() {
    let house = House::new();
    let life = house.life(60);
    let last = unlike(&life);
    let (_view, at) = house.view(&["--data", life.to_str().unwrap()]);
    let (status, live) = ask(&at, &of(LIVE, last));
    assert_eq!((status, &live["explanation"]), (Some(200), &Value::Null), "{live}");
    assert!(live["undecided"].as_str().unwrap().contains("can't be explained"), "{live}");
    assert!(live["schemas_total"].as_u64() > Some(0), "{live}");
    let list = |sort: &str| {
        of(&format!(r#"{{"ask":"schemas","generalised":false,"sort":"{sort}","limit":5,"offset":0}}"#), last)
    };
    for question in
        [list("age"), of(r#"{"ask":"show","id":3}"#, last), of(r#"{"ask":"graph","depth":1}"#, last)]
    {
        let (status, answer) = ask(&at, &question);
        assert_eq!(status, Some(200), "{question}: {answer}");
    }
    // What is told by the decision alone can't be told.
    for question in [list("excitation"), of(r#"{"ask":"why-not","id":3}"#, last)] {
        let (status, answer) = ask(&at, &question);
        assert_eq!(status, Some(422), "{question}: {answer}");
        assert!(answer["problem"].as_str().unwrap().contains("can't be explained"), "{answer}");
    }
    let (_, before) = ask(&at, &of(LIVE, 60));
    assert!(before["explanation"]["step"].is_u64() && before["undecided"].is_null(), "{before}");
}

#[test]
fn what_can_not_be_served_is_said_at_once() {
    let house = House::new();
    let (_view, at) = house.view(&[]);
    let taken = house.refusal(&["view", "--no-open", "--port", &at.port.to_string()]);
    assert!(taken.0 == Some(1) && taken.1.contains(&at.port.to_string()), "{taken:?}");
    std::fs::create_dir(house.path("empty")).unwrap();
    let nothing = house.refusal(&["view", "--no-open", "--data", house.path("empty").to_str().unwrap()]);
    assert!(nothing.0 == Some(1) && nothing.1.contains("there is no memory in"), "{nothing:?}");
}
