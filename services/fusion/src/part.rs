//! Role of the process: leader or standby.

use std::sync::Arc;
use std::time::Duration;

use bus::SharedMemory;
use fusion::Settings;
use messages::ProcessKind;
use runtime::Process;
use runtime::cores;
use runtime::housekeeping::Queues;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::agent::{FusionAgent, Ready};
use crate::continuity::{FusionStart, TakeOver};
use crate::smoothing::SmoothingQueue;
use crate::standby::{self, Lead, LeadLock, StandbyFusion};

/// Fusion process.
#[derive(Debug)]
pub(crate) struct FusionPart<'a> {
    process: &'a Process,
    queues: Arc<Queues>,
    smoothing: Option<Arc<SmoothingQueue>>,
    state: RoleState,
}

#[derive(Debug)]
enum RoleState {
    /// Until the process leads.
    Changes,
    StandsBy(Box<StandbyFusion>),
    Leads {
        agent: Box<FusionAgent<SharedMemory>>,
        /// Held as long as the process lives.
        _lead: Option<Lead>,
    },
}

impl<'a> FusionPart<'a> {
    /// Opens the inputs of fusion. With a configured standby, the process starts as standby; else as leader.
    ///
    /// # Errors
    /// If a setting is invalid, or a topic cannot be opened.
    pub(crate) fn new(
        process: &'a Process,
        settings: &Settings,
        lock: Option<LeadLock>,
        (queues, smoothing): (Arc<Queues>, Option<Arc<SmoothingQueue>>),
        now: Now,
    ) -> anyhow::Result<Self> {
        let (config, speed) = (&process.config, process.options.speed);
        let core = config.fusion.core;
        let ready = Ready::new(config, settings, (speed, core), &process.bus, process.incarnation)?;
        let mut part = Self {
            process,
            queues,
            smoothing,
            state: RoleState::Changes,
        };
        match lock {
            Some(lock) => {
                let standby = StandbyFusion::new(process, config.fusion.takeover_ns(), lock, ready, now);
                part.state = RoleState::StandsBy(Box::new(standby));
                part.call(standby::NAME);
            }
            None => part.lead(ready, None, TakeOver::default(), now)?,
        }
        Ok(part)
    }

    fn call(&self, name: &'static str) {
        // With a full queue, the process keeps an older name for a moment.
        let _ = self.queues.names.force_push(name);
    }

    fn lead(
        &mut self,
        ready: Ready<SharedMemory>,
        lead: Option<Lead>,
        take_over: TakeOver,
        now: Now,
    ) -> anyhow::Result<()> {
        let Process { config, bus, .. } = self.process;
        let incarnation = self.process.incarnation;
        // Recorded samples are sent again.
        let kept = config.checkpoint.max_age_ns().filter(|_| !config.is_recorded());
        let world_ns = config.is_simulated().then_some(self.process.options.scenario_start_ns);
        let look = |max_age_ns| FusionStart::look(bus.root(), max_age_ns, world_ns, &ready.engine, now);
        let start = kept.map(look);
        let epoch = start.as_ref().map_or(incarnation, |start| start.epoch);
        if let Some(whole) = start.as_ref().and_then(|start| start.whole(now)) {
            // There is a single start, and room for this entry.
            let _ = self.queues.restored.push(whole);
        }
        let agent = FusionAgent::begin(ready, config, bus, (incarnation, epoch), Arc::clone(&self.queues))?;
        let mut agent = agent.with_smoothing(self.smoothing.clone());
        if let Some(start) = start {
            agent.resume(start, take_over, now)?;
        }
        self.queues.lead();
        if lead.is_some() {
            self.take_core(take_over)?;
            self.call(ProcessKind::Fusion.word());
        }
        self.state = RoleState::Leads {
            agent: Box::new(agent),
            _lead: lead,
        };
        Ok(())
    }
}

impl FusionPart<'_> {
    /// Moves from the standby's core to the leader's core.
    ///
    /// # Errors
    /// If the core is required and refused. A fusion that takes over continues without the core.
    fn take_core(&self, take_over: TakeOver) -> anyhow::Result<()> {
        let fusion = &self.process.config.fusion;
        let refused = match (fusion.core, fusion.standby_core.filter(|_| fusion.standby)) {
            (Some(core), _) => cores::pin_to(core),
            (None, Some(_)) => cores::unpin(),
            (None, None) => Ok(()),
        };
        if let Err(reason) = refused {
            anyhow::ensure!(!fusion.required || take_over.from_another, "{reason}");
            runtime::notice(format_args!("warning: {reason}; going on without"));
        }
        Ok(())
    }
}

impl Agent for FusionPart<'_> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let standby = match &mut self.state {
            RoleState::Leads { agent, .. } => return agent.turn(now),
            RoleState::StandsBy(standby) => standby,
            RoleState::Changes => anyhow::bail!("could not come to lead"),
        };
        let Some((lead, take_over)) = standby.look(self.process, now)? else {
            return Ok(Turn::Idle(standby.pause()));
        };
        if let RoleState::StandsBy(standby) = std::mem::replace(&mut self.state, RoleState::Changes) {
            self.lead(standby.into_ready(), Some(lead), take_over, now)?;
        }
        Ok(Turn::Worked)
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        match &mut self.state {
            RoleState::Leads { agent, .. } => agent.wait(at_most),
            RoleState::StandsBy(standby) => {
                standby.wait(at_most);
                Ok(())
            }
            RoleState::Changes => Ok(()),
        }
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        match &self.state {
            RoleState::Leads { agent, .. } => agent.health(entries),
            RoleState::StandsBy(_) | RoleState::Changes => entries.push(HealthEntry::default()),
        }
    }

    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        match &mut self.state {
            RoleState::Leads { agent, .. } => agent.close(now),
            RoleState::StandsBy(_) | RoleState::Changes => Ok(()),
        }
    }
}
