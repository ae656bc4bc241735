//! Samples as they are published, for readers of events and for Foxglove.
//!
//! The world holds the latest states only; these readers want each sample. The agent puts the slices of each topic
//! that a reader has asked for into a queue of [`WAITING_MAX`] slices, which all readers share. A reader that falls
//! behind by more loses the oldest slices and learns their number; nobody waits for a reader. Without readers, nothing
//! is copied.

use std::fmt;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use deployment::Deployment;
use messages::layout::Layout;
use sample_text::{LineFormat, LineWriter, SampleNames};
use web::tokio::sync::broadcast;

use crate::layers::{DisplayedSample, ForDisplayed, for_displayed};

/// Most slices that wait for a reader. A slice has up to 64 samples.
pub(crate) const WAITING_MAX: usize = 1024;

/// Topics of a deployment, and the queue of their slices.
pub(crate) struct Feed {
    channels: Vec<FeedChannel>,
    slices: broadcast::Sender<Arc<FeedSlice>>,
}

/// A topic.
pub(crate) struct FeedChannel {
    pub(crate) topic: String,
    pub(crate) layout: &'static Layout,
    lines: LineWriter,
    /// Number of readers of the topic.
    readers: AtomicU32,
}

/// A slice of samples.
pub(crate) struct FeedSlice {
    /// Place of its topic among the channels.
    pub(crate) channel: usize,
    /// Time of receipt, UTC, nanoseconds.
    pub(crate) taken_ns: i64,
    octets: Vec<u8>,
    sample_size: usize,
    /// The samples as JSON, made for the first reader that wants them.
    lines: OnceLock<Vec<String>>,
}

impl FeedSlice {
    /// Returns the bytes of each sample.
    pub(crate) fn samples(&self) -> impl Iterator<Item = &[u8]> {
        self.octets.chunks_exact(self.sample_size)
    }

    /// Returns each sample as JSON, with the names of `koseki tap`.
    pub(crate) fn lines(&self, feed: &Feed) -> &[String] {
        self.lines.get_or_init(|| {
            let line = |sample| {
                let mut text = Vec::new();
                feed.channels[self.channel].lines.write(sample, &mut text);
                String::from_utf8_lossy(&text).trim_end().to_owned()
            };
            self.samples().map(line).collect()
        })
    }
}

impl fmt::Debug for Feed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Feed")
            .field("channels", &self.channels.len())
            .finish_non_exhaustive()
    }
}

impl Default for Feed {
    /// A feed without topics: that of a recording.
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl Feed {
    fn new(channels: Vec<FeedChannel>) -> Self {
        let (slices, _) = broadcast::channel(WAITING_MAX);
        Self { channels, slices }
    }

    /// Returns the feed of all displayed topics of a deployment.
    pub(crate) fn of(config: &Deployment) -> Self {
        let sources = config.sources.iter().map(|source| source.name.clone());
        let names = SampleNames::new(sources.collect(), config.frame);
        let channel =
            |(id, name): (messages::StreamId, &str)| for_displayed(id.stream, ChannelOf { name, names: &names });
        Self::new(config.streams().filter_map(channel).collect())
    }

    /// Returns the topics in the order of their places.
    pub(crate) fn channels(&self) -> &[FeedChannel] {
        &self.channels
    }

    /// Returns the place of a topic, by its name or without the beginning `system/`.
    pub(crate) fn place_of(&self, topic: &str) -> Option<usize> {
        let is_meant = |channel: &FeedChannel| {
            channel.topic == topic
                || channel
                    .topic
                    .strip_prefix("system/")
                    .is_some_and(|short| short == topic)
        };
        self.channels.iter().position(is_meant)
    }

    /// Hands a slice of the topic at `channel` to its readers.
    pub(crate) fn publish(&self, channel: usize, octets: &[u8], taken_ns: i64) {
        let Some(topic) = self.channels.get(channel) else {
            return;
        };
        if topic.readers.load(Ordering::Relaxed) == 0 || octets.is_empty() {
            return;
        }
        // Without a receiver, the last reader has just left.
        let _ = self.slices.send(Arc::new(FeedSlice {
            channel,
            taken_ns,
            octets: octets.to_vec(),
            sample_size: topic.layout.size,
            lines: OnceLock::new(),
        }));
    }
}

struct ChannelOf<'a> {
    name: &'a str,
    names: &'a SampleNames,
}

impl ForDisplayed for ChannelOf<'_> {
    type Done = FeedChannel;

    fn of<T: DisplayedSample>(self) -> FeedChannel {
        FeedChannel {
            topic: T::topic(self.name).name.as_str().to_owned(),
            layout: &T::LAYOUT,
            lines: LineWriter::new(&T::LAYOUT, LineFormat::Json, Some(self.names.clone())),
            readers: AtomicU32::new(0),
        }
    }
}

/// A reader of the feed, with the topics it wants.
pub(crate) struct FeedReader {
    feed: Arc<Feed>,
    slices: broadcast::Receiver<Arc<FeedSlice>>,
    /// Places of the wanted topics.
    wanted: Vec<usize>,
}

/// What a reader gets.
pub(crate) enum Fed {
    Slice(Arc<FeedSlice>),
    /// This number of slices was lost, since the reader was too slow.
    Lost(u64),
}

impl FeedReader {
    pub(crate) fn new(feed: &Arc<Feed>) -> Self {
        Self {
            feed: Arc::clone(feed),
            slices: feed.slices.subscribe(),
            wanted: Vec::new(),
        }
    }

    pub(crate) fn feed(&self) -> &Feed {
        &self.feed
    }

    /// Adds a topic. Returns whether the reader had not wanted the topic before.
    pub(crate) fn add(&mut self, channel: usize) -> bool {
        let is_new = !self.wanted.contains(&channel);
        if let Some(topic) = self.feed.channels.get(channel).filter(|_| is_new) {
            topic.readers.fetch_add(1, Ordering::Relaxed);
            self.wanted.push(channel);
        }
        is_new
    }

    /// Removes a topic.
    pub(crate) fn remove(&mut self, channel: usize) {
        let before = self.wanted.len();
        self.wanted.retain(|wanted| *wanted != channel);
        if self.wanted.len() < before {
            self.feed.channels[channel].readers.fetch_sub(1, Ordering::Relaxed);
        }
    }

    /// Waits for the next slice of a wanted topic; `None`: there will be no more. No slice is lost if the wait is given
    /// up.
    pub(crate) async fn next(&mut self) -> Option<Fed> {
        loop {
            match self.slices.recv().await {
                Ok(slice) if self.wanted.contains(&slice.channel) => return Some(Fed::Slice(slice)),
                Ok(_) => {}
                Err(broadcast::error::RecvError::Lagged(lost)) => return Some(Fed::Lost(lost)),
                Err(broadcast::error::RecvError::Closed) => return None,
            }
        }
    }
}

impl Drop for FeedReader {
    fn drop(&mut self) {
        while let Some(channel) = self.wanted.last().copied() {
            self.remove(channel);
        }
    }
}
