//! `pschema view`: a page to look into a learner with, served to this machine alone.
//!
//! The page is a tool like any other. One thread speaks HTTP; one asks the daemon; one reads the memory on disk as it
//! was at an earlier step; one watches the pictures of the bodies while a page does. The daemon knows of none of this.

mod answers;
mod asker;
mod assets;
mod guard;
mod http;
mod past;
mod pictures;
mod question;
mod shot;
mod token;
mod work;

use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use http::PageServer;
use past::Directory;
use pictures::Pictures;
use pschema_process::Stop;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use token::Token;

use crate::failure::Failure;

/// The learner to look at, and the port of the page.
#[derive(Debug)]
pub(crate) struct PageOptions {
    /// The learner whose daemon is asked, unless `data` names a directory.
    pub(crate) name: LearnerName,
    /// A data directory to be read, with or without a daemon on it.
    pub(crate) data: Option<PathBuf>,
    /// The port; 0 for any that is free.
    pub(crate) port: u16,
}

/// The page, before it is served.
pub(crate) struct ViewPage {
    listeners: Vec<TcpListener>,
    server: Arc<PageServer>,
    watching: Option<pictures::PictureThread>,
    /// Whose daemon is asked; none when only a data directory is looked at.
    place: Option<Place>,
}

impl ViewPage {
    /// Takes the port and begins to listen on it; nothing is answered before [`ViewPage::serve`].
    ///
    /// # Errors
    /// When the port is taken, or the system has no randomness.
    pub(crate) fn open(wanted: &PageOptions) -> Result<Self, Failure> {
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, wanted.port));
        let failed = |error: std::io::Error| {
            let port = wanted.port;
            Failure::Failed(format!(
                "cannot listen on {address}: {error}. Without `--port {port}` a port that is free is taken"
            ))
        };
        let listener = TcpListener::bind(address).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        // For many programs `localhost` is `::1` first. Where there is no IPv6, or another has that port, the printed address is enough.
        let beside = TcpListener::bind((Ipv6Addr::LOCALHOST, port))
            .and_then(|beside| beside.set_nonblocking(true).map(|()| beside))
            .inspect_err(|error| tracing::debug!(%error, "the page is not at [::1]"));
        let listeners = std::iter::once(listener).chain(beside).collect();
        let directory = Directory::default();
        let (live, watching, place) = match &wanted.data {
            Some(data) => {
                // Opened first, so that no page is offered of a directory that holds no memory.
                pschema_store::past::Past::open(data)?;
                directory.is(Some(data.clone()));
                (None, None, None)
            }
            None => {
                let place = Place::new(RuntimeDir::from_environment()?, wanted.name.clone());
                let pictures = pictures::watch(place.clone())?;
                (Some(asker::begin(place.clone(), directory.clone())?), Some(pictures), Some(place))
            }
        };
        let past = past::begin(directory)?;
        let pictures: Option<Pictures> = watching.as_ref().map(pictures::PictureThread::pictures);
        let server = Arc::new(PageServer { port, token: Token::draw()?, live, past, pictures });
        Ok(Self { listeners, server, watching, place })
    }

    /// The address of the page. It is shown only to the person who started it: whoever knows it can look at the learner and
    /// give orders.
    pub(crate) fn url(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.server.port, self.server.token.text())
    }

    /// Why the page has nothing to show yet; none where it has.
    pub(crate) fn waits_for(&self) -> Option<String> {
        self.place.as_ref()?.served().err().map(|error| error.to_string())
    }

    /// Serves it until `stop` is raised.
    ///
    /// # Errors
    /// When the system can't.
    pub(crate) fn serve(self, stop: &Stop) -> Result<(), Failure> {
        let Self { listeners, server, watching, .. } = self;
        let served = http::serve(listeners, server, stop);
        if let Some(watching) = watching {
            watching.end();
        }
        served
    }
}

/// A file that sends a browser to the page. So the address is in the arguments of no process, where other users could read
/// it.
///
/// # Errors
/// When it can't be written.
pub(crate) fn signpost(url: &str, folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    use std::io::Write;
    let mut file = tempfile::Builder::new().prefix("pschema-view-").suffix(".html").tempfile_in(folder)?;
    let page = maud::html! {
        (maud::DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="referrer" content="no-referrer";
                meta http-equiv="refresh" content=(format!("0;url={url}"));
                title { "pschema view" }
            }
            body { p { a href=(url) { "To the page" } } }
        }
    };
    file.write_all(page.into_string().as_bytes())?;
    file.flush()?;
    Ok(file)
}
