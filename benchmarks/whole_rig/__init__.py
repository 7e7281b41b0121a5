"""What a diagnosis says of sessions that went through simulated boards, camera and curves."""
