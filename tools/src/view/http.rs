//! HTTP, on one thread, with a limit on everything.

use std::convert::Infallible;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{ALLOW, CACHE_CONTROL, CONTENT_TYPE, HeaderName, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use pschema_process::Stop;
use tokio::sync::Semaphore;

use crate::failure::Failure;

use super::assets::asset;
use super::guard::{Denial, Route, way};
use super::pictures::Pictures;
use super::question::PageQuestion;
use super::shot::Fields;
use super::token::Token;
use super::work::{Trouble, Worker};

/// Connections at a time. A browser opens up to 6 for one page.
const CONNECTIONS_MAX: usize = 32;
/// Bytes of a request's head.
const HEAD_BYTES_MAX: usize = 16 * 1024;
/// Headers that a request may have.
const HEADERS_MAX: usize = 64;
/// Bytes of a question.
const QUESTION_BYTES_MAX: usize = 4 * 1024;
/// The time within which the head of a request, or the next request of a connection, must have come.
const HEAD_WITHIN: Duration = Duration::from_secs(10);
/// The time within which a question must have come once its head is there.
const QUESTION_WITHIN: Duration = Duration::from_secs(5);
/// The time from one look at the stop flag to the next.
const STOP_LOOKED_AT_EVERY: Duration = Duration::from_millis(50);
/// The pause after the system gave no more connections.
const ACCEPT_AGAIN_AFTER: Duration = Duration::from_millis(100);

/// Headers of every response: the page loads nothing from elsewhere, is shown inside no other page, is kept in no cache, and
/// tells no other page where a visitor comes from.
const HEADERS: [(HeaderName, HeaderValue); 7] = [
    (
        HeaderName::from_static("content-security-policy"),
        HeaderValue::from_static(
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
             base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        ),
    ),
    (HeaderName::from_static("x-content-type-options"), HeaderValue::from_static("nosniff")),
    (HeaderName::from_static("x-frame-options"), HeaderValue::from_static("DENY")),
    (HeaderName::from_static("referrer-policy"), HeaderValue::from_static("no-referrer")),
    (HeaderName::from_static("cross-origin-resource-policy"), HeaderValue::from_static("same-origin")),
    (HeaderName::from_static("cross-origin-opener-policy"), HeaderValue::from_static("same-origin")),
    (CACHE_CONTROL, HeaderValue::from_static("no-store")),
];

/// The page with those who answer its questions.
pub(super) struct PageServer {
    pub(super) port: u16,
    pub(super) token: Token,
    /// Asks the daemon; none when only a data directory is looked at.
    pub(super) live: Option<Worker>,
    /// Answers about the past.
    pub(super) past: Worker,
    /// The pictures; none without a daemon.
    pub(super) pictures: Option<Pictures>,
}

type Reply = Response<Full<Bytes>>;

/// Serves until `stop` is raised.
///
/// # Errors
/// When the system can't.
pub(super) fn serve(
    listeners: Vec<TcpListener>,
    server: Arc<PageServer>,
    stop: &Stop,
) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::Failed(format!("cannot serve a page: {error}"));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
    runtime.block_on(async {
        let places = Arc::new(Semaphore::new(CONNECTIONS_MAX));
        for listener in listeners {
            let listener = tokio::net::TcpListener::from_std(listener).map_err(failed)?;
            // Ends with the runtime, as all connections do.
            tokio::spawn(accept(listener, Arc::clone(&server), Arc::clone(&places)));
        }
        stopped(stop).await;
        Ok(())
    })
}

async fn stopped(stop: &Stop) {
    while !stop.is_raised() {
        tokio::time::sleep(STOP_LOOKED_AT_EVERY).await;
    }
}

async fn accept(listener: tokio::net::TcpListener, server: Arc<PageServer>, places: Arc<Semaphore>) {
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new())
        .header_read_timeout(HEAD_WITHIN)
        .max_buf_size(HEAD_BYTES_MAX)
        .max_headers(HEADERS_MAX);
    loop {
        // Connections above the limit wait in the queue of the system.
        let Ok(place) = Arc::clone(&places).acquire_owned().await else { return };
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(error) => {
                tracing::warn!(%error, "a connection could not be accepted");
                tokio::time::sleep(ACCEPT_AGAIN_AFTER).await;
                continue;
            }
        };
        let server = Arc::clone(&server);
        let serve = service_fn(move |request| {
            let server = Arc::clone(&server);
            async move { Ok::<_, Infallible>(with_headers(reply(&server, request).await)) }
        });
        let connection = http.serve_connection(TokioIo::new(stream), serve);
        tokio::spawn(async move {
            if let Err(error) = connection.await {
                tracing::debug!(%error, "a connection ended");
            }
            drop(place);
        });
    }
}

fn with_headers(mut reply: Reply) -> Reply {
    for (name, value) in HEADERS {
        reply.headers_mut().insert(name, value);
    }
    reply
}

async fn reply(server: &PageServer, request: Request<Incoming>) -> Reply {
    let uri = request.uri();
    match way(request.method(), uri.path(), request.headers(), server.port, &server.token) {
        Ok(Route::Asset(name)) => match asset(name) {
            Some(asset) => content(StatusCode::OK, asset.kind, asset.text),
            None => refused(Denial(StatusCode::NOT_FOUND, "there is no such file".into())),
        },
        Ok(Route::Ask) => answered(server, request.into_body()).await,
        Ok(Route::Picture) => picture(server, after(uri.query())).await,
        Ok(Route::Fields) => fields(server),
        Err(why) => refused(why),
    }
}

fn content(status: StatusCode, kind: &'static str, body: impl Into<Bytes>) -> Reply {
    let mut reply = Response::new(Full::new(body.into()));
    *reply.status_mut() = status;
    reply.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    reply
}

const JSON: &str = "application/json";
const PLAIN: &str = "text/plain; charset=utf-8";

fn refused(Denial(status, why): Denial) -> Reply {
    let mut reply = content(status, PLAIN, format!("{why}\n"));
    if status == StatusCode::METHOD_NOT_ALLOWED {
        reply.headers_mut().insert(ALLOW, HeaderValue::from_static("GET, POST"));
    }
    reply
}

fn trouble(trouble: &Trouble) -> Reply {
    content(trouble.status, JSON, serde_json::to_vec(trouble).unwrap_or_default())
}

async fn answered(server: &PageServer, body: Incoming) -> Reply {
    let asked = match question(body).await {
        Ok(asked) => asked,
        Err(why) => return trouble(&why),
    };
    let answer = match &server.live {
        Some(live) if asked.until.is_none() => live.ask(asked).await,
        _ => server.past.ask(asked).await,
    };
    match answer {
        Ok(json) => content(StatusCode::OK, JSON, json),
        Err(why) => trouble(&why),
    }
}

async fn question(body: Incoming) -> Result<PageQuestion, Trouble> {
    let slow = |_| Trouble::new(StatusCode::REQUEST_TIMEOUT, "the question did not come to its end");
    let long = |_| {
        let problem = format!("a question has at most {QUESTION_BYTES_MAX} bytes, and comes whole");
        Trouble::new(StatusCode::PAYLOAD_TOO_LARGE, problem)
    };
    let whole = Limited::new(body, QUESTION_BYTES_MAX).collect();
    let bytes = tokio::time::timeout(QUESTION_WITHIN, whole).await.map_err(slow)?.map_err(long)?.to_bytes();
    serde_json::from_slice(&bytes).map_err(|error| {
        Trouble::new(StatusCode::BAD_REQUEST, format!("that is no question of this page: {error}"))
    })
}

/// The number in `after=17`; for any other text 0, which is the number of no picture.
fn after(query: Option<&str>) -> u64 {
    query.and_then(|query| query.strip_prefix("after=")?.parse().ok()).unwrap_or(0)
}

async fn picture(server: &PageServer, after: u64) -> Reply {
    let shot = match &server.pictures {
        Some(pictures) => pictures.after(after).await,
        None => None,
    };
    let Some(shot) = shot else { return content(StatusCode::NO_CONTENT, PLAIN, Bytes::new()) };
    let mut reply = content(StatusCode::OK, "image/png", shot.png.clone());
    for (name, value) in [("picture", shot.number), ("fields", shot.fields_version)] {
        reply.headers_mut().insert(name, HeaderValue::from(value));
    }
    reply
}

fn fields(server: &PageServer) -> Reply {
    match server.pictures.as_ref().and_then(Pictures::last) {
        Some(shot) => {
            content(StatusCode::OK, JSON, serde_json::to_vec(&Fields::from(&*shot)).unwrap_or_default())
        }
        None => content(StatusCode::NO_CONTENT, PLAIN, Bytes::new()),
    }
}
