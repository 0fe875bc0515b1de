//! How long the stages of a list of passes take on the device.

use crate::choose::Clock;
use crate::context::Context;
use crate::error::{Fault, during};
use ash::vk;
use slabsplat_gpu::Pass;
use std::sync::Arc;

/// No pool of queries is smaller.
const MIN_TIMES: u32 = 32;

/// The stages of a list of passes, each with the passes of it.
pub(crate) fn stages(passes: &[Pass]) -> impl Iterator<Item = &[Pass]> + Clone {
    passes.chunk_by(|pass, next| pass.stage == next.stage)
}

/// Times that the device notes: one before the first stage, and one after each.
pub(crate) struct StageTimes {
    pub(crate) queries: vk::QueryPool,
    /// Times that there is room for.
    pub(crate) capacity: u32,
    clock: Clock,
    context: Arc<Context>,
}

impl StageTimes {
    pub(crate) fn new(context: &Arc<Context>, clock: Clock, n_times: u32) -> Result<Self, Fault> {
        let capacity = n_times.next_power_of_two().max(MIN_TIMES);
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(capacity);
        // SAFETY: the queue has timestamps, or there would be no clock.
        let queries = unsafe { context.functions.create_query_pool(&info, None) }
            .map_err(during("vkCreateQueryPool"))?;
        Ok(Self { queries, capacity, clock, context: Arc::clone(context) })
    }

    /// Milliseconds from each of the first times to the next, once the device is done. If the driver
    /// has none after all, that is not worth a frame: then there are no times.
    pub(crate) fn durations_ms(&self, n_times: u32) -> Result<Vec<f64>, Fault> {
        let mut ticks = vec![0_u64; n_times as usize];
        let flags = vk::QueryResultFlags::TYPE_64;
        // SAFETY: the commands that note these times are done, and there is room for as many.
        let read = unsafe {
            self.context.functions.get_query_pool_results(self.queries, 0, &mut ticks, flags)
        };
        match read {
            Ok(()) => Ok(ticks.windows(2).map(|pair| self.clock.ms(pair[0], pair[1])).collect()),
            Err(vk::Result::ERROR_DEVICE_LOST) => {
                Err(during("vkGetQueryPoolResults")(vk::Result::ERROR_DEVICE_LOST))
            }
            Err(_) => Ok(Vec::new()),
        }
    }
}

impl Drop for StageTimes {
    fn drop(&mut self) {
        // SAFETY: it goes with its recording, which the device is done with.
        unsafe { self.context.functions.destroy_query_pool(self.queries, None) };
    }
}

impl Clock {
    /// Milliseconds from one time to a later one, also if the clock began anew in between.
    fn ms(self, from: u64, to: u64) -> f64 {
        let n_ticks = to.wrapping_sub(from) & self.mask;
        n_ticks as f64 * self.ns_per_tick * 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_counts_on_after_its_end() {
        let clock = Clock { ns_per_tick: 500.0, mask: 0xff };
        assert_eq!(clock.ms(10, 30), 0.01);
        assert_eq!(clock.ms(0xf0, 0x04), 0.01);
        // Bits that do not count may be anything.
        assert_eq!(clock.ms(0x300 + 10, 30), 0.01);
    }
}
