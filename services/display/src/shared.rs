//! State shared by the agent and the server.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use runtime::Now;

use crate::feed::Feed;
use crate::orders::OrderQueue;
use crate::settings::MapFiles;
use crate::status::Audience;
use crate::views::Views;
use crate::world::World;

/// State shared by the agent and the server.
#[derive(Debug)]
pub(crate) struct SharedState {
    world: Mutex<World>,
    /// Files of the map.
    pub(crate) maps: MapFiles,
    /// Orders of operators.
    pub(crate) orders: OrderQueue,
    /// What operators and their guests share besides orders.
    pub(crate) desk: Desk,
    /// Reads the clocks.
    pub(crate) clock: fn() -> Now,
    pub(crate) traffic: Arc<TrafficCounts>,
    /// Samples as they are published.
    pub(crate) feed: Arc<Feed>,
}

/// What operators and their guests share besides orders.
#[derive(Debug, Default)]
pub(crate) struct Desk {
    /// Whether the configuration admits operators.
    pub(crate) has_operators: bool,
    pub(crate) views: Views,
}

/// Counts of pages and pictures.
#[derive(Debug, Default)]
pub(crate) struct TrafficCounts {
    pub(crate) pages: AtomicU64,
    pub(crate) sent: AtomicU64,
    pub(crate) skipped: AtomicU64,
    /// Pages refused or closed: too many, malformed, too slow.
    pub(crate) refused: AtomicU64,
}

impl SharedState {
    /// Creates the shared state of a world and the files of its map, without published samples.
    pub(crate) fn new(world: World, maps: MapFiles, clock: fn() -> Now) -> Arc<Self> {
        Self::fed(world, maps, clock, Feed::default(), Desk::default())
    }

    /// Creates the shared state of a world, the files of its map, the samples as they are published, and a desk.
    pub(crate) fn fed(world: World, maps: MapFiles, clock: fn() -> Now, feed: Feed, desk: Desk) -> Arc<Self> {
        Arc::new(Self {
            world: Mutex::new(world),
            maps,
            orders: OrderQueue::default(),
            desk,
            clock,
            traffic: Arc::default(),
            feed: Arc::new(feed),
        })
    }

    /// Creates the shared state of another world of the same display.
    pub(crate) fn beside(&self, world: World) -> Arc<Self> {
        Arc::new(Self {
            world: Mutex::new(world),
            maps: self.maps.clone(),
            orders: OrderQueue::default(),
            desk: Desk::default(),
            clock: self.clock,
            traffic: Arc::clone(&self.traffic),
            feed: Arc::clone(&self.feed),
        })
    }

    /// Locks the world.
    pub(crate) fn world(&self) -> MutexGuard<'_, World> {
        // A page whose task panicked has changed nothing.
        self.world.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn audience(&self) -> Audience {
        Audience {
            clients: self.traffic.pages.load(Ordering::Relaxed),
            skipped: self.traffic.skipped.load(Ordering::Relaxed),
        }
    }
}
