use std::time::Duration;

use protocol::field::Field;
use protocol::message::{Diagnostic, ToOrchestrator};
use protocol::monitor::{MonitorReceiver, MonitorSender};
use protocol::runspace::RunSpace;

const LIMIT: Duration = Duration::from_secs(10);

fn diagnostics(value: f64) -> Vec<Diagnostic> {
    vec![Diagnostic {
        name: "step".to_owned(),
        value,
    }]
}

/// Grains that are left after a step: three, two after step 100, none after step 150.
fn grains(step: u64) -> usize {
    match step {
        0..=99 => 3,
        100..=149 => 2,
        _ => 0,
    }
}

/// The coupler's part: 200 steps, a snapshot every 50, until it is told to stop.
fn coupler(runspace: &RunSpace) {
    let mut sender = MonitorSender::connect(runspace).unwrap().unwrap();
    sender.started(2, &[], None, &[0.1, 0.2, 0.3]).unwrap();
    let mut last = 0;
    for step in 1..=200_u32 {
        sender.step(diagnostics(f64::from(step))).unwrap();
        last = step;
        if step % 50 == 0 {
            let left = grains(step.into());
            let position = vec![f64::from(step); 2 * left];
            sender
                .snapshot(
                    (step.into(), 0.5),
                    left,
                    &[(Field::GrainPosition, &position)],
                )
                .unwrap();
        }
        if sender.stop_requested() {
            break;
        }
    }
    sender.finished(diagnostics(last.into())).unwrap();
}

#[test]
fn steps_and_snapshots_arrive_in_order_and_stop_stops() {
    let runspace = RunSpace::create().unwrap();
    let mut receiver = MonitorReceiver::create(&runspace).unwrap();
    assert_eq!(receiver.next(Duration::from_millis(20)).unwrap(), None);
    let there = runspace.clone();
    let thread = std::thread::spawn(move || coupler(&there));
    let first = receiver.next(LIMIT).unwrap().unwrap();
    assert!(matches!(
        first.message,
        ToOrchestrator::Started {
            grains: 3,
            nodes: 0,
            ..
        }
    ));
    assert_eq!(first.fields, [(Field::GrainRadius, vec![0.1, 0.2, 0.3])]);
    let (mut steps, mut snapshots) = (0, 0);
    let last = loop {
        let event = receiver
            .next(LIMIT)
            .unwrap()
            .expect("a message within 10 s");
        match event.message {
            ToOrchestrator::Step(values) => {
                steps += 1;
                assert_eq!(values, diagnostics(f64::from(steps)));
            }
            ToOrchestrator::Snapshot { step, .. } => {
                snapshots += 1;
                assert_eq!((step, steps), (50 * snapshots, 50 * snapshots as u32));
                let position = vec![step as f64; 2 * grains(step)];
                assert_eq!(event.fields, [(Field::GrainPosition, position)]);
                if snapshots == 3 {
                    receiver.stop().unwrap();
                }
            }
            ToOrchestrator::Finished(totals) => break totals[0].value,
            other => panic!("{other:?}"),
        }
    };
    println!("stopped after step {last}, {steps} steps and {snapshots} snapshots seen");
    assert_eq!(last, f64::from(steps));
    assert!(snapshots >= 3);
    thread.join().unwrap();
}

#[test]
fn a_run_without_orchestrator_has_no_monitor() {
    let runspace = RunSpace::named("alone").unwrap();
    assert!(MonitorSender::connect(&runspace).unwrap().is_none());
}
