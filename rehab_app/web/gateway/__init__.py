"""The filtering gateway between browsers and the viewports, which listen on loopback only."""
