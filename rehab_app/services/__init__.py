"""Every verb that pages and commands may call, role-checked and audited."""
