"""The arm: closed-form kinematics and inverses, limits of its joints."""
