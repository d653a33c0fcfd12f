//! One end of a link over iceoryx2, for both back ends.
//!
//! A link has a publish-subscribe service of bytes for the messages of each direction, one of f64
//! for each field and direction, and an event service for each end. State always comes from the
//! queues; an event only ends a wait. In lock step at most two samples wait in a queue, so a full
//! queue means that the partner broke the order or hangs: sending then fails after a limit.

use std::any::Any;
use std::collections::BTreeMap;
use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{
    AllocationStrategy, Config, LogLevel, Node, NodeBuilder, NodeName, SignalHandlingMode,
    set_log_level,
};
use iceoryx2::service::Service;
use iceoryx2::service::port_factory::PortFactory as _;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::buffers::{Arrived, Loaned};
use super::ends::End;
use super::services::{
    Fields, Messages, culprit, delivered, event_service, field_service, loaning, message_publisher,
    message_service, opening, patience, sending, service_name,
};
use crate::language::error::Error;
use crate::language::field::Field;
use crate::language::header::{FieldHeader, check_sum};
use crate::run::liveness::Board;
use crate::run::place::{making_files, preflight};
use crate::transport::channel::{Channel, Loan, Received, Wait};

/// Wake-ups are looked at this often even when none arrives; only a lost one would need it.
const TICK: Duration = Duration::from_secs(1);
/// How long to look for an answer before sleeping; the waking of a sleeping core takes about as long.
const AWAKE: Duration = Duration::from_micros(50);

/// A flavour of iceoryx2 whose listeners can be polled together with other descriptors.
pub(crate) trait Backend: Service + 'static {
    /// Descriptor that is readable while a wake-up is pending.
    fn descriptor(listener: &Listener<Self>) -> BorrowedFd<'_>;
    /// Called when a node was made: what the library leaves open to others is closed.
    fn close_to_others(_config: &Config) -> Result<(), Error> {
        Ok(())
    }
}

/// A publisher of one field; made when it is first needed, when its size is known.
struct Output<S: Service> {
    service: Fields<S>,
    publisher: Option<Publisher<S, [f64], FieldHeader>>,
    capacity: usize,
}

/// One end of a link.
pub(crate) struct Link<S: Backend> {
    end: End,
    board: Arc<Board>,
    messages_service: Messages<S>,
    messages_out: Publisher<S, [u8], FieldHeader>,
    messages_in: Subscriber<S, [u8], FieldHeader>,
    outputs: BTreeMap<Field, Output<S>>,
    inputs: BTreeMap<Field, Subscriber<S, [f64], FieldHeader>>,
    listener: Listener<S>,
    notifier: Notifier<S>,
    check: bool,
    token: Option<String>,
    // Last, in this order: ports go before their node, and all files before the membership.
    _node: Node<S>,
    _membership: Box<dyn Any>,
}

impl<S: Backend> Link<S> {
    /// Open this end; the other end may come before or after. `membership` is dropped last.
    pub(crate) fn open(
        config: &Config,
        end: End,
        board: Arc<Board>,
        token: Option<String>,
        membership: Box<dyn Any>,
    ) -> Result<Link<S>, Error> {
        set_log_level(LogLevel::Warn);
        let _guard = making_files();
        let name = format!("{}-{}", end.me, end.link);
        let node = NodeBuilder::new()
            .name(&NodeName::new(&name).map_err(|e| opening(&name, e))?)
            .config(config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<S>()
            .map_err(|e| opening(&name, e))?;
        S::close_to_others(config)?;
        let (out, back) = (format!("to_{}", end.peer), format!("to_{}", end.me));
        let messages_service =
            message_service(&node, &service_name(&end, &out, "messages"), end.queue)?;
        let messages_out = message_publisher(&messages_service, &end, &board)?;
        let name = service_name(&end, &back, "messages");
        let messages_in = message_service(&node, &name, end.queue)?
            .subscriber_builder()
            .create()
            .map_err(|e| opening(&name, e))?;
        let mut outputs = BTreeMap::new();
        for &field in end.sends {
            let service = field_service(&node, &service_name(&end, &out, field.name()))?;
            outputs.insert(
                field,
                Output {
                    service,
                    publisher: None,
                    capacity: 0,
                },
            );
        }
        let mut inputs = BTreeMap::new();
        for &field in end.receives {
            let name = service_name(&end, &back, field.name());
            let subscriber = field_service(&node, &name)?.subscriber_builder().create();
            inputs.insert(field, subscriber.map_err(|e| opening(&name, e))?);
        }
        let listener = event_service(&node, &service_name(&end, end.me, "wake"))?;
        let listener = listener
            .listener_builder()
            .create()
            .map_err(|e| opening("listener", e))?;
        let notifier = event_service(&node, &service_name(&end, end.peer, "wake"))?;
        let notifier = notifier
            .notifier_builder()
            .create()
            .map_err(|e| opening("notifier", e))?;
        let check = std::env::var_os("SILLAGE_CHECK").is_some();
        let link = Link {
            end,
            board,
            messages_service,
            messages_out,
            messages_in,
            outputs,
            inputs,
            listener,
            notifier,
            check,
            token,
            _node: node,
            _membership: membership,
        };
        // A partner that is there already may be waiting for this end.
        let _ = link.notifier.notify();
        Ok(link)
    }

    /// Look with `take` until it finds something; block in between, after a short while of looking
    /// only: an answer that comes at once is then not waited for by a sleeping core, whose waking takes
    /// as long as the exchange. Whoever else wants the core gets it at every look.
    fn wait_for<T>(
        &mut self,
        wait: Wait<'_>,
        mut take: impl FnMut(&mut Self) -> Result<Option<T>, Error>,
    ) -> Result<T, Error> {
        if let Some(found) = take(self)? {
            return Ok(found);
        }
        let begun = Instant::now();
        while begun.elapsed() < AWAKE {
            std::thread::yield_now();
            if let Some(found) = take(self)? {
                return Ok(found);
            }
        }
        self.board.begin_wait(wait.step, wait.awaited);
        let found = loop {
            self.settle()?;
            let missing = self.end.missing(&self.board);
            // What it sent before it left still counts.
            if let Some(found) = take(self)? {
                break found;
            }
            if let Some(who) = missing {
                return Err(wait.lost(&who));
            }
            if wait.left().is_zero() {
                return Err(wait.passed(self.end.peer));
            }
            self.block(wait.left().min(TICK))?;
        };
        self.board.end_wait();
        Ok(found)
    }

    /// Take away all pending wake-ups, so that the next one is sure to make the descriptor readable;
    /// what they announced must be looked for afterwards, before blocking.
    ///
    /// A notifier skips the descriptor while it believes a wake-up to be pending. A drain that races
    /// with it can take the byte and leave that belief behind (iceoryx2 0.10): a drain that finds
    /// nothing is the one that clears it.
    fn settle(&self) -> Result<(), Error> {
        loop {
            let found = self
                .listener
                .try_wait(|_| {})
                .map_err(|e| Error::transport("wake-up", e))?;
            if found == 0 {
                return Ok(());
            }
        }
    }

    /// Block until a wake-up or an alarm.
    fn block(&self, limit: Duration) -> Result<(), Error> {
        let pending = S::descriptor(&self.listener);
        let alarm = self.board.alarm();
        let mut fds = [
            PollFd::new(&pending, PollFlags::IN),
            PollFd::new(&alarm, PollFlags::IN),
        ];
        let timeout = Timespec::try_from(limit).ok();
        match poll(&mut fds, timeout.as_ref()) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(e) => return Err(Error::transport("poll", e)),
        }
        let alarmed = !fds[1].revents().is_empty();
        if alarmed {
            self.board.drain();
        }
        Ok(())
    }

    /// The publisher of a field, large enough for `count` numbers.
    fn publisher(
        &mut self,
        field: Field,
        count: usize,
    ) -> Result<&Publisher<S, [f64], FieldHeader>, Error> {
        let (name, board, end) = (field.name(), &self.board, &self.end);
        let output = self.outputs.get_mut(&field).ok_or_else(|| {
            Error::transport(
                name,
                format!(
                    "the {} does not send this field to the {}",
                    end.me, end.peer
                ),
            )
        })?;
        if count > output.capacity {
            // The pages in use: one being written, one being read, one waiting.
            preflight(3 * 8 * count as u64)?;
            output.capacity = count.next_power_of_two();
        }
        if output.publisher.is_none() {
            let publisher = output
                .service
                .publisher_builder()
                .initial_max_slice_len(count + count / 2 + 1)
                .allocation_strategy(AllocationStrategy::PowerOfTwo)
                .max_loaned_samples(1)
                .set_backpressure_handler(patience(end, board))
                .create()
                .map_err(|e| opening(name, e))?;
            output.publisher = Some(publisher);
        }
        output
            .publisher
            .as_ref()
            .ok_or_else(|| Error::transport(name, "no publisher"))
    }
}

impl<S: Backend> Channel for Link<S> {
    fn peer(&self) -> &str {
        self.end.peer
    }

    fn send_message(&mut self, header: FieldHeader, bytes: &[u8]) -> Result<bool, Error> {
        // The first one makes the connection.
        let _guard = making_files();
        let mut sample = self
            .messages_out
            .loan_slice_uninit(bytes.len())
            .map_err(|e| loaning("message", e))?;
        *sample.user_header_mut() = header;
        let receivers = sample.write_from_slice(bytes).send();
        let receivers =
            receivers.map_err(|e| sending("message", header.step, &self.end, &self.board, e))?;
        self.notifier
            .notify()
            .map_err(|e| Error::transport("wake-up", e))?;
        Ok(receivers > 0)
    }

    fn poll_message(&mut self) -> Result<Option<(FieldHeader, Vec<u8>)>, Error> {
        let sample = self
            .messages_in
            .receive()
            .map_err(|e| Error::transport("message", e))?;
        Ok(sample.map(|sample| (*sample.user_header(), sample.payload().to_vec())))
    }

    fn receive_message(&mut self, wait: Wait<'_>) -> Result<(FieldHeader, Vec<u8>), Error> {
        self.wait_for(wait, Self::poll_message)
    }

    fn loan_field(&mut self, field: Field, header: FieldHeader) -> Result<Box<dyn Loan>, Error> {
        let guard = making_files();
        let publisher = self.publisher(field, header.count as usize)?;
        let mut sample = publisher
            .loan_slice_uninit(header.count as usize)
            .map_err(|e| loaning(field.name(), e))?;
        drop(guard);
        *sample.user_header_mut() = header;
        let sample = sample.write_from_fn(|_| f64::NAN);
        Ok(Box::new(Loaned {
            sample,
            field,
            check: self.check,
            end: self.end.clone(),
            board: Arc::clone(&self.board),
        }))
    }

    fn send_field(
        &mut self,
        field: Field,
        mut header: FieldHeader,
        values: &[f64],
    ) -> Result<(), Error> {
        if self.check {
            header.check = check_sum(values);
        }
        let guard = making_files();
        let publisher = self.publisher(field, values.len())?;
        let mut sample = publisher
            .loan_slice_uninit(values.len())
            .map_err(|e| loaning(field.name(), e))?;
        drop(guard);
        *sample.user_header_mut() = header;
        let receivers = sample.write_from_slice(values).send();
        delivered(field.name(), header.step, &self.end, &self.board, receivers)
    }

    fn receive_field(&mut self, field: Field, wait: Wait<'_>) -> Result<Box<dyn Received>, Error> {
        self.wait_for(wait, |link| {
            let subscriber = link.inputs.get(&field).ok_or_else(|| {
                Error::invalid(
                    link.end.peer,
                    wait.step,
                    field.name(),
                    format!("the {} does not send this field", link.end.peer),
                )
            })?;
            let sample = subscriber
                .receive()
                .map_err(|e| Error::transport(field.name(), e))?;
            Ok(sample.map(|sample| Box::new(Arrived { sample }) as Box<dyn Received>))
        })
    }

    fn idle(&mut self, wait: Wait<'_>, limit: Duration) -> Result<(), Error> {
        self.board.begin_wait(wait.step, wait.awaited);
        if let Some(who) = self.end.missing(&self.board) {
            return Err(wait.lost(&who));
        }
        if wait.left().is_zero() {
            return Err(wait.passed(self.end.peer));
        }
        self.block(limit.min(wait.left()))?;
        self.settle()?;
        self.board.end_wait();
        Ok(())
    }

    fn wait_for_leave(&mut self, limit: Duration) -> bool {
        let wait = Wait::new(0, "its leave", limit);
        while !self.board.is_gone(self.end.peer) {
            let waited = self
                .settle()
                .and_then(|()| self.block(wait.left().min(TICK)));
            if wait.left().is_zero() || waited.is_err() {
                return false;
            }
        }
        true
    }

    fn has_reader(&mut self) -> Result<bool, Error> {
        Ok(self
            .messages_service
            .dynamic_config()
            .number_of_subscribers()
            > 0)
    }

    fn culprit(&mut self) -> String {
        culprit(&self.end, &self.board)
    }

    fn anyone_is_lost(&self) -> bool {
        self.board.anyone_is_lost()
    }

    fn peer_is_gone(&self) -> bool {
        self.board.is_gone(self.end.peer)
    }

    fn token(&self) -> Option<&str> {
        self.token.as_deref()
    }
}
