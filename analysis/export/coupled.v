(* ---- Channels with one nonlinearity, whatever the order of their sigma ---- *)

(* The form of phi (sigma_i) - l sigma_i and k sigma_i - phi (sigma_i), each times q. *)
Definition leaf_of (M rows : list (list Z)) : halves :=
  Leaf (map (fun r => (0%Z, map (Z.max 0) (snd r))) (matrix (bilinear M rows rows))).
Definition in_all_orders (odds : bool) (M : list (list Z)) (T : nat) : bool :=
  all_positive M T (cases odds T) (map (fun c => leaf_of M (rows_in T (fst c) (snd c))) (cases odds T)).
Lemma dot_scaled : forall r q w, dot r (map (Rmult q) w) = q * dot r w.
Proof. induction r as [|a r IH]; intros q [|x w]; cbn [dot map]; try ring; rewrite IH; ring. Qed.
Lemma coupled_sound : forall odds M T l k phi q rows z samples, in_all_orders odds M T = true ->
  sloped odds l k phi -> length samples = T -> at_ rows z = map (Rmult q) (window l k phi samples) ->
  0 <= value (bilinear M rows rows) z.
Proof.
  intros odds M T l k phi q rows z samples test [Z [S O_]] len E.
  assert (H : 0 <= V M (window l k phi samples)).
  { destruct odds; [now apply (odd_orders_sound M T _ l k phi test Z S (O_ eq_refl))|now apply (orders_sound M T _ l k phi test Z S)]. }
  assert (V_scaled : forall N w, sumprod (map (Rmult q) w) (map (fun r => dot r (at_ rows z)) N)
    = q * q * sumprod w (map (fun r => dot r (window l k phi samples)) N)).
  { rewrite E; induction N as [|r N IH]; intros [|x w]; cbn [sumprod map]; try ring; rewrite IH, dot_scaled; ring. }
  rewrite value_bilinear; rewrite E at 1; rewrite V_scaled; unfold V in H; nra.
Qed.
