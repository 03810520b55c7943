from lumped.live.live_page import live_page as live_page
