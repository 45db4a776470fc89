"""What a finished graph must fulfil before it may fly."""
