//! The same code for processors with wide registers; nothing is fused, so it has the same bits.

/// Something to compute. `run` and all that it calls must be inlined: only then it is compiled for wide registers.
pub trait Task {
    /// What comes out.
    type Output;

    /// Compute it.
    fn run(self) -> Self::Output;
}

/// Are there registers for four numbers? Only a processor can say so.
#[derive(Debug, Clone, Copy)]
pub struct Wide(bool);

impl Wide {
    /// What this processor has.
    pub fn here() -> Wide {
        #[cfg(target_arch = "x86_64")]
        return Wide(std::is_x86_feature_detected!("avx2"));
        #[cfg(not(target_arch = "x86_64"))]
        return Wide(false);
    }

    /// As if there were none.
    #[cfg(test)]
    pub fn none() -> Wide {
        Wide(false)
    }

    /// Run a task, in wide registers where there are any.
    pub fn run<T: Task>(self, task: T) -> T::Output {
        #[cfg(target_arch = "x86_64")]
        if self.0 {
            // SAFETY: the processor has told that it knows AVX2.
            return unsafe { run_wide(task) };
        }
        task.run()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_wide<T: Task>(task: T) -> T::Output {
    task.run()
}
