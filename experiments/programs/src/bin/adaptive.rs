experiments::experiment_main!();
