experiments::alone!();
