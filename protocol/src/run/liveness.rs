//! Noticing that a partner process ended: a thread blocked in `poll` on the pidfds of all other
//! processes of the run and on changes of the run's seats.
//!
//! It writes what it saw on a [`Board`] and raises the board's alarm, which ends the main thread's
//! wait at once. A main thread that is busy computing does not look at the board: after
//! [`GRACE`] the watching thread itself reports the loss and ends the process with exit code 5.

use std::collections::BTreeMap;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};
use rustix::fs::inotify;
use rustix::process::{Pid, PidfdFlags, pidfd_open};

use super::lock::seats;
use super::place;
use super::signals;
use crate::language::error::Error;
use crate::run::members::{self, Member};

/// How long a busy main thread may take to notice a loss.
pub const GRACE: Duration = Duration::from_millis(500);

/// What a loss does to a process that does not notice it by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OnLoss {
    /// Exit with code 5 (engines and coupler).
    Exit,
    /// Nothing more (a process that hosts links but is no part of the run, e.g. a test).
    Report,
}

/// Where a partner is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Presence {
    Here,
    Left,
    Lost,
}

/// What the main thread is doing, for the message of a loss.
#[derive(Debug, Clone, Default)]
struct Activity {
    step: u64,
    awaited: String,
    waiting: bool,
}

/// What one process knows about its partners.
#[derive(Debug)]
pub(crate) struct Board {
    state: Mutex<State>,
    alarm: OwnedFd,
}

#[derive(Debug, Default)]
struct State {
    partners: BTreeMap<String, Presence>,
    activity: Activity,
    noticed: bool,
}

impl Board {
    /// A board with nobody on it; fails when no more files may be open.
    pub(crate) fn new() -> Result<Board, Error> {
        let flags = EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC;
        let alarm = eventfd(0, flags).map_err(|e| Error::memory("event of losses", e))?;
        Ok(Board {
            state: Mutex::default(),
            alarm,
        })
    }

    /// Becomes readable when something changed.
    pub(crate) fn alarm(&self) -> BorrowedFd<'_> {
        self.alarm.as_fd()
    }

    /// Make the alarm unreadable again; call before looking.
    pub(crate) fn drain(&self) {
        let mut count = [0_u8; 8];
        let _ = rustix::io::read(&self.alarm, &mut count);
    }

    /// The main thread begins to wait for something.
    pub(crate) fn begin_wait(&self, step: u64, awaited: &str) {
        let activity = &mut self.state().activity;
        activity.step = step;
        activity.awaited.clear();
        activity.awaited.push_str(awaited);
        activity.waiting = true;
    }

    /// The main thread has what it waited for.
    pub(crate) fn end_wait(&self) {
        self.state().activity.waiting = false;
    }

    /// A partner that makes waiting for `peer` pointless: anyone lost, or `peer` itself gone.
    pub(crate) fn missing(&self, peer: &str) -> Option<String> {
        let mut state = self.state();
        let lost = |(_, presence): &(&String, &Presence)| **presence == Presence::Lost;
        let culprit = state
            .partners
            .iter()
            .find(lost)
            .map(|(name, _)| name.clone());
        if culprit.is_some() {
            state.noticed = true;
        }
        culprit.or_else(|| {
            state
                .partners
                .get(peer)
                .filter(|&&p| p != Presence::Here)
                .map(|_| peer.to_owned())
        })
    }

    /// Has this partner left or been lost?
    pub(crate) fn is_gone(&self, peer: &str) -> bool {
        self.state()
            .partners
            .get(peer)
            .is_some_and(|&p| p != Presence::Here)
    }

    /// Has any partner been lost?
    pub(crate) fn anyone_is_lost(&self) -> bool {
        self.state().partners.values().any(|&p| p == Presence::Lost)
    }

    /// A partner left as agreed.
    pub(crate) fn mark_left(&self, peer: &str) {
        self.mark(peer, Presence::Left);
    }

    fn mark(&self, peer: &str, presence: Presence) {
        self.state().partners.insert(peer.to_owned(), presence);
        let _ = rustix::io::write(&self.alarm, &1_u64.to_ne_bytes());
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The watching thread of a process; ends when dropped.
#[derive(Debug)]
pub(crate) struct Watch {
    board: Arc<Board>,
    stop: Arc<OwnedFd>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    /// Watch all other processes in the seats under `root`.
    pub(crate) fn start(id: &str, root: &Path, on_loss: OnLoss) -> Result<Watch, Error> {
        let trouble =
            |e: rustix::io::Errno| Error::memory(format!("watch of {}", root.display()), e);
        let board = Arc::new(Board::new()?);
        let stop =
            Arc::new(eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC).map_err(trouble)?);
        let changes = inotify::init(inotify::CreateFlags::NONBLOCK | inotify::CreateFlags::CLOEXEC)
            .map_err(trouble)?;
        inotify::add_watch(
            &changes,
            seats(root),
            inotify::WatchFlags::MOVED_TO
                | inotify::WatchFlags::MOVED_FROM
                | inotify::WatchFlags::DELETE,
        )
        .map_err(trouble)?;
        let mut watcher = Watcher {
            id: id.to_owned(),
            root: root.to_owned(),
            board: Arc::clone(&board),
            changes,
            known: BTreeMap::new(),
            on_loss,
            lost_at: None,
        };
        watcher.rescan();
        let stop_here = Arc::clone(&stop);
        let thread = std::thread::Builder::new()
            .name("liveness".to_owned())
            .spawn(move || watcher.run(&stop_here))
            .map_err(|e| Error::memory("thread of the watch", e))?;
        Ok(Watch {
            board,
            stop,
            thread: Some(thread),
        })
    }

    /// What it sees.
    pub(crate) fn board(&self) -> Arc<Board> {
        Arc::clone(&self.board)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = rustix::io::write(&*self.stop, &1_u64.to_ne_bytes());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What ended a wait of the watching thread.
enum Seen {
    /// The watch is over.
    Stop,
    /// This process was told to end by a signal.
    Told,
    /// These seats' processes ended; none: the seats changed, or time passed.
    Ended(Vec<String>),
}

/// State of the watching thread.
struct Watcher {
    id: String,
    root: PathBuf,
    board: Arc<Board>,
    changes: OwnedFd,
    known: BTreeMap<String, (Member, OwnedFd)>,
    on_loss: OnLoss,
    lost_at: Option<Instant>,
}

impl Watcher {
    fn run(mut self, stop: &OwnedFd) {
        loop {
            match self.wait(stop) {
                Seen::Stop => return,
                Seen::Told => self.end(signals::told_code()),
                Seen::Ended(seats) => seats.iter().for_each(|seat| self.ended(seat)),
            }
            self.rescan();
            self.enforce();
        }
    }

    /// Block until something happens, or until a loss that nobody noticed must be enforced.
    fn wait(&self, stop: &OwnedFd) -> Seen {
        // Polled only where there is one: descriptors are looked at one after another, and any
        // other in its place could become ready in between.
        let told = signals::told();
        let mut fds = vec![
            PollFd::new(stop, PollFlags::IN),
            PollFd::new(&self.changes, PollFlags::IN),
        ];
        fds.extend(told.iter().map(|told| PollFd::new(told, PollFlags::IN)));
        let others = fds.len();
        fds.extend(
            self.known
                .values()
                .map(|(_, pidfd)| PollFd::new(pidfd, PollFlags::IN)),
        );
        let left = self.lost_at.map(|at| GRACE.saturating_sub(at.elapsed()));
        let timeout = left.and_then(|left| Timespec::try_from(left).ok());
        if poll(&mut fds, timeout.as_ref()).is_err() {
            return Seen::Ended(Vec::new());
        }
        let ready: Vec<bool> = fds.iter().map(|fd| !fd.revents().is_empty()).collect();
        if ready[0] {
            return Seen::Stop;
        }
        if told.is_some() && ready[2] {
            return Seen::Told;
        }
        let ended = self
            .known
            .keys()
            .zip(&ready[others..])
            .filter(|(_, ready)| **ready);
        Seen::Ended(ended.map(|(seat, _)| seat.clone()).collect())
    }

    /// Leave the run and end this process.
    fn end(&self, code: i32) -> ! {
        let _nothing_new = place::stop_making_files();
        place::leave(&self.id);
        // No destructors: the main thread is in the middle of something.
        signals::exit_at_once(code)
    }

    /// A process ended; lost if its seat is still taken by it.
    fn ended(&mut self, seat: &str) {
        let Some((member, _)) = self.known.remove(seat) else {
            return;
        };
        match members::all(&self.root).get(seat) {
            Some(now) if *now == member => self.lost(seat),
            _ => self.board.mark(seat, Presence::Left),
        }
    }

    fn lost(&mut self, seat: &str) {
        self.lost_at.get_or_insert_with(Instant::now);
        self.board.mark(seat, Presence::Lost);
        place::remove_unfinished(&self.id);
    }

    /// Compare the seats with what is known.
    fn rescan(&mut self) {
        let mut events = [0_u8; 4096];
        while rustix::io::read(&self.changes, &mut events).is_ok_and(|length| length > 0) {}
        let seats = members::all(&self.root);
        let gone: Vec<String> = self
            .known
            .keys()
            .filter(|seat| !seats.contains_key(*seat))
            .cloned()
            .collect();
        for seat in gone {
            self.known.remove(&seat);
            self.board.mark(&seat, Presence::Left);
        }
        for (seat, member) in seats {
            let watched = self
                .known
                .get(&seat)
                .is_some_and(|(known, _)| *known == member);
            let reported = self.board.state().partners.get(&seat) == Some(&Presence::Lost);
            if !watched && !reported && member.pid != std::process::id() {
                self.meet(seat, member);
            }
        }
    }

    fn meet(&mut self, seat: String, member: Member) {
        let pid = i32::try_from(member.pid).ok().and_then(Pid::from_raw);
        let pidfd = pid.and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        match pidfd {
            Some(pidfd) if members::is_held(&self.root, &seat) => {
                self.known.insert(seat.clone(), (member, pidfd));
                self.board.mark(&seat, Presence::Here);
            }
            // It may have left between the two looks; then its seat is free.
            _ if members::all(&self.root).get(&seat) == Some(&member) => self.lost(&seat),
            _ => {}
        }
    }

    /// End a process whose main thread has not noticed a loss in time.
    fn enforce(&mut self) {
        let Some(at) = self.lost_at else { return };
        let (activity, noticed, culprit) = {
            let state = self.board.state();
            let lost = state
                .partners
                .iter()
                .find(|(_, p)| **p == Presence::Lost)
                .map(|(name, _)| name.clone());
            (
                state.activity.clone(),
                state.noticed,
                lost.unwrap_or_default(),
            )
        };
        if noticed || self.on_loss == OnLoss::Report {
            self.lost_at = None;
        } else if at.elapsed() >= GRACE {
            let busy = "this process's own computation to end";
            let doing = if activity.waiting {
                activity.awaited
            } else {
                busy.to_owned()
            };
            let error = Error::PartnerLost {
                who: culprit,
                step: activity.step,
                awaited: doing,
            };
            tracing::error!("{error}");
            self.end(error.exit_code());
        }
    }
}
