"""What a configuration's solution is made of: elements, contacts, measured curves."""
