//! The order of submissions: a semaphore that counts up, and that the processor can ask without waiting.

use crate::commands::Commands;
use crate::context::Context;
use crate::error::{Fault, during};
use ash::vk;
use std::sync::Arc;
use std::time::Duration;

/// How long a submission is waited for. Drivers that only play a card take minutes for what one does in a
/// second.
const MOST_PATIENCE: Duration = Duration::from_secs(600);

/// Gives each submission a number, one more than the last, which the semaphore reaches when the
/// submission is done.
pub(crate) struct Timeline {
    semaphore: vk::Semaphore,
    last: u64,
    context: Arc<Context>,
    /// What the driver is to answer, in tests.
    #[cfg(test)]
    pub(crate) forced: std::cell::Cell<Option<ForcedAnswer>>,
}

/// A failure of the driver to be.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForcedAnswer {
    /// Of this function.
    pub(crate) function: &'static str,
    /// After as many calls that the driver answers.
    pub(crate) n_calls_before: u32,
    pub(crate) result: vk::Result,
}

impl Timeline {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self, Fault> {
        let mut kind = vk::SemaphoreTypeCreateInfo::default()
            .semaphore_type(vk::SemaphoreType::TIMELINE)
            .initial_value(0);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
        // SAFETY: the device was made with timeline semaphores.
        let semaphore = unsafe { context.functions.create_semaphore(&info, None) }
            .map_err(during("vkCreateSemaphore"))?;
        Ok(Self {
            semaphore,
            last: 0,
            context: Arc::clone(context),
            #[cfg(test)]
            forced: std::cell::Cell::default(),
        })
    }

    /// The number of the last submission; 0 before the first.
    pub(crate) fn last(&self) -> u64 {
        self.last
    }

    /// Begins lists of commands, one after the other, and says their common number.
    pub(crate) fn submit(&mut self, lists: &[&Commands]) -> Result<u64, Fault> {
        self.answer("vkQueueSubmit")?;
        let number = self.last + 1;
        let numbers = [number];
        let semaphores = [self.semaphore];
        let mut timeline =
            vk::TimelineSemaphoreSubmitInfo::default().signal_semaphore_values(&numbers);
        let handles: Vec<_> = lists.iter().map(|list| list.handle).collect();
        let info = vk::SubmitInfo::default()
            .command_buffers(&handles)
            .signal_semaphores(&semaphores)
            .push_next(&mut timeline);
        // SAFETY: the lists are recorded and not with the device at the moment, as `AshDevice` keeps
        // account of; the number is greater than all before; the queue is this thread's, for the
        // `AshDevice` is borrowed mutably.
        let submitted = unsafe {
            self.context.functions.queue_submit(self.context.queue, &[info], vk::Fence::null())
        };
        submitted.map_err(during("vkQueueSubmit"))?;
        self.last = number;
        Ok(number)
    }

    /// The number of the last submission that is done. Does not wait.
    pub(crate) fn done(&self) -> Result<u64, Fault> {
        self.answer("vkGetSemaphoreCounterValue")?;
        // SAFETY: the semaphore is a timeline.
        let value = unsafe { self.context.functions.get_semaphore_counter_value(self.semaphore) };
        let value = value.map_err(during("vkGetSemaphoreCounterValue"))?;
        if self.last < value {
            // Some drivers say so when the device is lost.
            return Err(Fault::Driver("the semaphore is ahead of what was submitted".to_owned()));
        }
        Ok(value)
    }

    /// Waits until a submission is done.
    pub(crate) fn wait(&self, number: u64) -> Result<(), Fault> {
        // Drivers end work that takes too long, and then say that the device is lost; those that do not
        // even do that are not waited for until the end of days.
        if self.is_done_within(number, MOST_PATIENCE)? {
            return Ok(());
        }
        let minutes = MOST_PATIENCE.as_secs() / 60;
        Err(Fault::Driver(format!("vkWaitSemaphores: no answer within {minutes} minutes")))
    }

    /// The same, but no longer than that.
    pub(crate) fn wait_at_most(&self, number: u64, at_most: Duration) -> Result<(), Fault> {
        self.is_done_within(number, at_most).map(drop)
    }

    fn is_done_within(&self, number: u64, at_most: Duration) -> Result<bool, Fault> {
        if self.answer("vkWaitSemaphores")? == Some(vk::Result::TIMEOUT) {
            return Ok(false);
        }
        let semaphores = [self.semaphore];
        let numbers = [number];
        let at_most_ns = u64::try_from(at_most.as_nanos()).unwrap_or(u64::MAX);
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&numbers);
        // SAFETY: the semaphore is a timeline, and the number was submitted.
        match unsafe { self.context.functions.wait_semaphores(&info, at_most_ns) } {
            Ok(()) => Ok(true),
            Err(vk::Result::TIMEOUT) => Ok(false),
            Err(error) => Err(during("vkWaitSemaphores")(error)),
        }
    }

    /// What a test wants a function to answer: a failure, or that time was up.
    #[cfg(test)]
    fn answer(&self, function: &'static str) -> Result<Option<vk::Result>, Fault> {
        let Some(forced) = self.forced.get().filter(|forced| forced.function == function) else {
            return Ok(None);
        };
        if let Some(n_calls_before) = forced.n_calls_before.checked_sub(1) {
            self.forced.set(Some(ForcedAnswer { n_calls_before, ..forced }));
            return Ok(None);
        }
        self.forced.set(None);
        match forced.result {
            vk::Result::TIMEOUT => Ok(Some(vk::Result::TIMEOUT)),
            failure => Err(during(function)(failure)),
        }
    }

    #[cfg(not(test))]
    fn answer(&self, _function: &'static str) -> Result<Option<vk::Result>, Fault> {
        Ok(None)
    }
}

impl Drop for Timeline {
    fn drop(&mut self) {
        // SAFETY: an `AshDevice` waits for the queue before it drops its parts.
        unsafe { self.context.functions.destroy_semaphore(self.semaphore, None) };
    }
}
