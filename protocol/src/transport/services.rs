//! The iceoryx2 services of a link: how they are named, made and limited, and what their errors
//! mean for a run.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::{BackpressureAction, BackpressureInfo, LoanError, SendError};
use iceoryx2::prelude::{
    Alignment, AllocationStrategy, Config, FileName, Node, SemanticString, ServiceName,
};
use iceoryx2::service::Service;
use iceoryx2::service::port_factory::event::PortFactory as Events;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::language::codec;
use crate::language::error::Error;
use crate::language::header::FieldHeader;
use crate::language::header::PROTOCOL_VERSION;
use crate::run::awake;
use crate::run::liveness::Board;
use crate::transport::channel::Wait;

use super::ends::End;

/// Fields that may wait in a queue, and samples that a receiver may hold.
const QUEUE: usize = 2;

pub(crate) type Fields<S> = PortFactory<S, [f64], FieldHeader>;
pub(crate) type Messages<S> = PortFactory<S, [u8], FieldHeader>;

/// The configuration of iceoryx2 for one run: own prefix, own folder, nothing from files.
pub(crate) fn configuration(root: &Path, prefix: &str) -> Result<Config, Error> {
    let mut config = Config::default();
    let trouble = |e| Error::transport("name of the run", format!("{e:?}"));
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(trouble)?;
    let root = root.to_string_lossy();
    let path = iceoryx2::prelude::Path::new(root.as_bytes()).map_err(trouble)?;
    config.global.set_root_path(&path);
    // A run removes its files itself. The library's own removal waits without end for a segment that
    // somebody was killed over between making and sizing it (iceoryx2 0.10).
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

pub(crate) fn service_name(end: &End, direction: &str, what: &str) -> String {
    format!("sillage/{PROTOCOL_VERSION}/{}/{direction}/{what}", end.link)
}

fn named(name: &str) -> Result<ServiceName, Error> {
    ServiceName::new(name).map_err(|e| opening(name, e))
}

pub(crate) fn message_service<S: Service>(
    node: &Node<S>,
    name: &str,
    queue: usize,
) -> Result<Messages<S>, Error> {
    node.service_builder(&named(name)?)
        .publish_subscribe::<[u8]>()
        .user_header::<FieldHeader>()
        .enable_safe_overflow(false)
        .subscriber_max_buffer_size(queue)
        .subscriber_max_borrowed_samples(QUEUE)
        .history_size(0)
        .max_publishers(1)
        .max_subscribers(1)
        .max_nodes(4)
        .open_or_create()
        .map_err(|e| opening(name, e))
}

pub(crate) fn message_publisher<S: Service>(
    service: &Messages<S>,
    end: &End,
    board: &Arc<Board>,
) -> Result<Publisher<S, [u8], FieldHeader>, Error> {
    service
        .publisher_builder()
        .initial_max_slice_len(codec::LIMIT)
        .allocation_strategy(AllocationStrategy::PowerOfTwo)
        .max_loaned_samples(1)
        .set_backpressure_handler(patience(end, board))
        .create()
        .map_err(|e| opening("publisher of messages", e))
}

pub(crate) fn field_service<S: Service>(node: &Node<S>, name: &str) -> Result<Fields<S>, Error> {
    // Also what a SIMD kernel likes to find.
    const CACHE_LINE: usize = 64;
    let alignment = Alignment::new(CACHE_LINE).ok_or_else(|| opening(name, "alignment"))?;
    node.service_builder(&named(name)?)
        .publish_subscribe::<[f64]>()
        .user_header::<FieldHeader>()
        .payload_alignment(alignment)
        .enable_safe_overflow(false)
        .subscriber_max_buffer_size(QUEUE)
        .subscriber_max_borrowed_samples(QUEUE)
        .history_size(0)
        .max_publishers(1)
        .max_subscribers(1)
        .max_nodes(4)
        .open_or_create()
        .map_err(|e| opening(name, e))
}

pub(crate) fn event_service<S: Service>(node: &Node<S>, name: &str) -> Result<Events<S>, Error> {
    node.service_builder(&named(name)?)
        .event()
        .max_notifiers(2)
        .max_listeners(1)
        .max_nodes(4)
        .open_or_create()
        .map_err(|e| opening(name, e))
}

/// Retry a full queue until the partner is gone or patience ends, then fail.
pub(crate) fn patience(
    end: &End,
    board: &Arc<Board>,
) -> impl Fn(&BackpressureInfo) -> BackpressureAction + Send + 'static {
    let (end, board) = (end.clone(), Arc::clone(board));
    let begun = Mutex::new(Duration::ZERO);
    move |info| {
        let mut begun = begun.lock().unwrap_or_else(PoisonError::into_inner);
        if info.retries == 0 {
            *begun = awake::now();
        }
        let full_for = awake::now().saturating_sub(*begun);
        if full_for >= end.patience || end.missing(&board).is_some() {
            BackpressureAction::DiscardDataAndFail
        } else {
            BackpressureAction::Retry
        }
    }
}

/// A partner that left because of somebody's loss may be seen before that loss is.
pub(crate) fn culprit(end: &End, board: &Board) -> String {
    const AT_MOST: Duration = Duration::from_millis(100);
    let wait = Wait::new(0, "a loss", AT_MOST);
    while !wait.left().is_zero() && !board.anyone_is_lost() {
        board.drain();
        let alarm = board.alarm();
        let timeout = Timespec::try_from(wait.left()).ok();
        let _ = poll(&mut [PollFd::new(&alarm, PollFlags::IN)], timeout.as_ref());
    }
    board
        .missing(end.peer)
        .unwrap_or_else(|| end.peer.to_owned())
}

pub(crate) fn delivered(
    what: &str,
    step: u64,
    end: &End,
    board: &Board,
    receivers: Result<usize, SendError>,
) -> Result<(), Error> {
    match receivers {
        Ok(0) => {
            let who = culprit(end, board);
            Err(Error::PartnerLost {
                who,
                step,
                awaited: format!("a receiver of {what}"),
            })
        }
        Ok(_) => Ok(()),
        Err(error) => Err(sending(what, step, end, board, error)),
    }
}

pub(crate) fn sending(what: &str, step: u64, end: &End, board: &Board, error: SendError) -> Error {
    let awaited = format!("room for {what} in its queue");
    match (error, end.missing(board)) {
        (SendError::UnableToDeliver, Some(who)) => Error::PartnerLost { who, step, awaited },
        (SendError::UnableToDeliver, None) => Error::TimeLimit {
            who: end.peer.to_owned(),
            step,
            awaited,
            seconds: end.patience.as_secs_f64(),
        },
        (error, _) => Error::transport(format!("sending {what} to the {}", end.peer), error),
    }
}

pub(crate) fn loaning(what: &str, error: LoanError) -> Error {
    Error::memory(format!("buffer for {what}"), error)
}

pub(crate) fn opening(name: &str, error: impl std::fmt::Debug) -> Error {
    let why = format!("{error:?}");
    // What two different versions of the library say about each other's files.
    let hint = if why.contains("Corrupted") || why.contains("VersionMismatch") {
        "; probably a process of this run uses another version of iceoryx2 (0.10.0 is required)"
    } else {
        ""
    };
    Error::transport(format!("opening {name}"), why + hint)
}
